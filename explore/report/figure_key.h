// Marks of a figure and what they mean.
#pragma once

#include "report/figures.h"

namespace explore::report {

// Where there is no answer; no boxes: nothing.
void add_hatched(Panel& panel, Boxes boxes);
// A way of light colour with a dark border, and squares at its ends.
void draw_way(Panel& panel, const std::vector<double>& x, const std::vector<double>& y,
              const std::vector<double>& ends_x, const std::vector<double>& ends_y);

// Marks and what they mean, below each other from the top; each is drawn into a square at the left.
class Key {
public:
    Key(double left, double top); // cm
    void line(Colour colour, bool dashed, double width, const std::string& words);
    void minimum(const std::string& words);
    void mark(Line style, const std::string& words); // its marker
    void text(const std::string& words);             // without a mark
    void valley(const std::string& words);
    void box(Colour colour, bool hatched, const std::string& words);
    // How far it reaches to the right of its left edge, cm.
    double reach() const { return 0.75 + 0.165 * static_cast<double>(longest_); }
    Panel done();

private:
    double middle() const { return -count_ - 0.5; }
    std::size_t longest_ = 0; // letters
    Panel panel_;
    double count_ = 0.0;
};

} // namespace explore::report
