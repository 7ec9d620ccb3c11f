#include "base/text.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace pave {
namespace {

// Bytes of the character that begins the text, by table 3-7 of the Unicode standard; 0: none does.
std::size_t character_length(std::string_view text) {
    const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
    const auto follows = [&](std::size_t i, unsigned low = 0x80, unsigned high = 0xbf) {
        return byte(i) >= low && byte(i) <= high;
    };
    const unsigned first = byte(0);
    if (first < 0x80) {
        return 1;
    }
    if (first >= 0xc2 && first <= 0xdf) {
        return follows(1) ? 2 : 0;
    }
    if (first >= 0xe0 && first <= 0xef) {
        const bool second = follows(1, first == 0xe0 ? 0xa0 : 0x80, first == 0xed ? 0x9f : 0xbf);
        return second && follows(2) ? 3 : 0;
    }
    if (first >= 0xf0 && first <= 0xf4) {
        const bool second = follows(1, first == 0xf0 ? 0x90 : 0x80, first == 0xf4 ? 0x8f : 0xbf);
        return second && follows(2) && follows(3) ? 4 : 0;
    }
    return 0;
}

} // namespace

std::size_t first_not_utf8(std::string_view text) {
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = text[i] == '\0' ? 0 : character_length(text.substr(i));
        if (length == 0) {
            return i;
        }
        i += length;
    }
    return std::string_view::npos;
}

std::string to_utf8(std::string text) {
    if (first_not_utf8(text) == std::string_view::npos) {
        return text;
    }
    std::string converted;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x80) {
            converted += c;
        } else {
            converted += static_cast<char>(0xc0 | byte >> 6);
            converted += static_cast<char>(0x80 | (byte & 0x3f));
        }
    }
    return converted;
}

std::string printable(std::string_view text, std::size_t limit) {
    constexpr std::string_view digits = "0123456789abcdef";
    std::string shown;
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = character_length(text.substr(i));
        const auto byte = static_cast<unsigned char>(text[i]);
        std::string next(text.substr(i, std::max<std::size_t>(length, 1)));
        if (text[i] == '\n') {
            next = "\\n";
        } else if (text[i] == '\t') {
            next = "\\t";
        } else if (length == 0 || byte < 0x20 || byte == 0x7f) {
            next = {'\\', 'x', digits[byte >> 4], digits[byte & 15]};
        }
        if (shown.size() + next.size() > limit) {
            return shown + "...";
        }
        shown += next;
        i += std::max<std::size_t>(length, 1);
    }
    return shown;
}

std::string figure(double value) {
    if (value == 0.0 || !std::isfinite(value)) {
        return fmt::format("{}", value);
    }
    const int digits = 3 - static_cast<int>(std::floor(std::log10(std::abs(value))));
    return digits < 0   ? fmt::format("{:.0f}", value)
           : digits > 9 ? fmt::format("{:.3e}", value)
                        : fmt::format("{:.{}f}", value, digits);
}

std::string counted(std::size_t count, const std::string& one, const std::string& many) {
    return fmt::format("{} {}", count, count == 1 ? one : many);
}

} // namespace pave
