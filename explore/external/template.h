// An input file of a program with places for values: {{base.k1}}, {{base.k1:%12.5e}}.
#pragma once

#include "base/outcome.h"

#include <span>
#include <string>
#include <vector>

namespace explore::external {

class Template {
public:
    // file: as messages call it; names: of the values, in their order. A place without a format takes the shortest
    // number that reads back the same. Throws pave::Error for a name that there is not, and for a format that is none
    // of a number (%e, %f, %g with flags, width and precision).
    Template(std::string text, std::string file, const std::vector<std::string>& names);

    // invalid-parameters where a value is wider than its format says: columns to its right would shift.
    pave::Outcome<std::string> filled(std::span<const double> values) const;
    bool uses(std::size_t value) const;

    const std::string& text() const { return text_; }
    const std::string& file() const { return file_; }

private:
    struct Place {
        std::string before; // the text between the place before and this one
        std::size_t value = 0;
        std::string name;
        std::string format; // printf's; "": shortest
        std::size_t width = 0;
    };
    std::string text_, file_;
    std::vector<Place> places_;
    std::string rest_;
};

} // namespace explore::external
