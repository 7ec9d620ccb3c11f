// Text of others: is it UTF-8, and how is it shown?
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace pave {

// Where the first byte stands that does not belong to a character of UTF-8, or that is zero; npos: nowhere.
std::size_t first_not_utf8(std::string_view text);

// The text itself where it is UTF-8, else its bytes read as ISO 8859-1, as older instruments write it.
std::string to_utf8(std::string text);

// UTF-16 as UTF-8: known by its byte order mark, or by every second byte of its beginning being zero. Other text is
// returned as it is. Half a pair of surrogates becomes U+FFFD.
std::string utf16_to_utf8(std::string text);

// For a line of a terminal: what is not a printable character as \n, \t or \x1b, and no more than `limit` bytes, the
// rest left out as "...".
std::string printable(std::string_view text, std::size_t limit = std::string_view::npos);

// So many significant digits, no exponent for the magnitudes of pavements: "5500", "0.7000", "-0.006628".
std::string figure(double value, int significant = 4);

// "p = 0.012", "p < 1e-6"
std::string p_words(double p);

// "1 minimum", "2 minima"
std::string counted(std::size_t count, const std::string& one, const std::string& many);

} // namespace pave
