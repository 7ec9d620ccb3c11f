// Arithmetic that a user writes: "0.7 * base.k1", "min(asphalt.modulus_MPa, 3000) - 500".
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace pave {

class Expression {
public:
    // known: names that may stand in the text; they may hold full stops, hyphens and spaces. A name is taken where no
    // letter, digit, underscore or full stop touches it; the longest one counts. Throws std::invalid_argument, in
    // words, for a text that is no arithmetic of numbers and these names.
    Expression(std::string text, const std::vector<std::string>& known);

    const std::string& text() const { return text_; }
    // The names that the text reads, in order of first appearance.
    const std::vector<std::string>& reads() const { return reads_; }
    // values: of reads(). May be infinite or no number. Safe from several threads.
    double value(const std::vector<double>& values) const;

private:
    std::string text_;
    std::string plain_; // with _0, _1, ... in place of the names
    std::vector<std::string> reads_;
};

} // namespace pave
