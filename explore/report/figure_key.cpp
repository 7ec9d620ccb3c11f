#include "report/figure_key.h"

#include <algorithm>

namespace explore::report {

void add_hatched(Panel& panel, Boxes boxes) {
    if (boxes.left.empty()) {
        return;
    }
    boxes.colours = {0xF0F0F0};
    panel.layers.emplace_back(boxes);
    boxes.colours = {grey};
    boxes.hatched = true;
    panel.layers.emplace_back(std::move(boxes));
}

void draw_way(Panel& panel, const std::vector<double>& x, const std::vector<double>& y,
              const std::vector<double>& ends_x, const std::vector<double>& ends_y) {
    for (const bool outer : {true, false}) {
        panel.layers.emplace_back(Line{.x = x, .y = y, .colour = outer ? black : white, .width = outer ? 2.8 : 1.4});
    }
    for (const bool outer : {true, false}) {
        panel.layers.emplace_back(Line{.x = ends_x,
                                       .y = ends_y,
                                       .colour = outer ? black : white,
                                       .width = 0.0,
                                       .marker = Marker::square,
                                       .marker_size = outer ? 1.4 : 0.9});
    }
}

Key::Key(double left, double top) {
    panel_.left = left;
    panel_.bottom = top - 0.5;
    panel_.width = 6.0;
    panel_.height = 0.5;
    panel_.framed = false;
    panel_.x.high = 6.0;
    panel_.y.low = -1.0;
    panel_.y.high = 0.0;
}

void Key::line(Colour colour, bool dashed, double width, const std::string& words) {
    Line line{.x = {0.0, 0.55}, .y = {middle(), middle()}, .colour = colour, .width = width, .dashed = dashed};
    panel_.layers.emplace_back(std::move(line));
    text(words);
}

void Key::minimum(const std::string& words) {
    for (const bool outer : {true, false}) {
        Line mark;
        mark.x = {0.275};
        mark.y = {middle()};
        mark.width = 0.0;
        mark.marker = Marker::circle;
        mark.marker_size = outer ? 1.5 : 0.95;
        mark.colour = outer ? black : white;
        panel_.layers.emplace_back(std::move(mark));
    }
    text(words);
}

void Key::mark(Line style, const std::string& words) {
    style.x = {0.275};
    style.y = {middle()};
    style.width = 0.0;
    panel_.layers.emplace_back(std::move(style));
    text(words);
}

void Key::valley(const std::string& words) {
    draw_way(panel_, {0.0, 0.55}, {middle(), middle()}, {0.55}, {middle()});
    text(words);
}

void Key::box(Colour colour, bool hatched, const std::string& words) {
    Boxes boxes{{0.0}, {0.55}, {middle() - 0.32}, {middle() + 0.32}, {colour}, false};
    if (hatched) {
        add_hatched(panel_, std::move(boxes));
    } else {
        panel_.layers.emplace_back(std::move(boxes));
    }
    text(words);
}

Panel Key::done() {
    // Rows are 1 apart whatever the height of the panel.
    const double rows = std::max(1.0, count_);
    panel_.bottom += 0.5 - 0.5 * rows;
    panel_.height = 0.5 * rows;
    panel_.y.low = -rows;
    for (Note& note : panel_.notes) {
        note.y = 1.0 + note.y / rows;
    }
    return std::move(panel_);
}

void Key::text(const std::string& words) {
    panel_.notes.push_back({0.75 / 6.0, middle(), words});
    count_ += 1.0;
    longest_ = std::max(longest_, words.size());
}

} // namespace explore::report
