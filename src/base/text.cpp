#include "base/text.h"

#include "base/windows_1252.h"

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

namespace {

// -1: not UTF-16; 0: little end first; 1: big end first.
int utf16_order(std::string_view text) {
    if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) {
        return text[0] == '\xff' ? 0 : 1;
    }
    const std::size_t looked_at = std::min<std::size_t>(text.size() / 2, 32);
    std::size_t zeros[2] = {0, 0};
    for (std::size_t i = 0; i < 2 * looked_at; ++i) {
        zeros[i % 2] += text[i] == '\0' ? 1 : 0;
    }
    const auto most = [&](std::size_t n) { return looked_at > 3 && 10 * n >= 9 * looked_at; };
    return most(zeros[1]) && zeros[0] == 0 ? 0 : most(zeros[0]) && zeros[1] == 0 ? 1 : -1;
}

void append_utf8(std::string& text, unsigned code) {
    const auto follow = [&](int shift) { text += static_cast<char>(0x80 | (code >> shift & 0x3f)); };
    if (code < 0x80) {
        text += static_cast<char>(code);
    } else if (code < 0x800) {
        text += static_cast<char>(0xc0 | code >> 6);
        follow(0);
    } else if (code < 0x10000) {
        text += static_cast<char>(0xe0 | code >> 12);
        follow(6);
        follow(0);
    } else {
        text += static_cast<char>(0xf0 | code >> 18);
        follow(12);
        follow(6);
        follow(0);
    }
}

// Windows-1252 at 0x80 to 0x9f, where ISO 8859-1 has controls that no text holds; 0: nothing.
constexpr unsigned windows_1252[32] = {0x20ac, 0,      0x201a, 0x0192, 0x201e, 0x2026, 0x2020, 0x2021,
                                       0x02c6, 0x2030, 0x0160, 0x2039, 0x0152, 0,      0x017d, 0,
                                       0,      0x2018, 0x2019, 0x201c, 0x201d, 0x2022, 0x2013, 0x2014,
                                       0x02dc, 0x2122, 0x0161, 0x203a, 0x0153, 0,      0x017e, 0x0178};

} // namespace

std::string to_utf8(std::string text) {
    if (first_not_utf8(text) == std::string_view::npos) {
        return text;
    }
    std::string converted;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        const unsigned of_windows = byte >= 0x80 && byte < 0xa0 ? windows_1252[byte - 0x80] : 0;
        append_utf8(converted, of_windows != 0 ? of_windows : byte);
    }
    return converted;
}

bool is_of_windows_1252(std::string_view character) {
    return std::any_of(std::begin(windows_1252), std::end(windows_1252), [&](unsigned code) {
        std::string text;
        append_utf8(text, code);
        return code != 0 && text == character;
    });
}

std::string utf16_to_utf8(std::string text) {
    const int order = utf16_order(text);
    if (order < 0) {
        return text;
    }
    const auto unit = [&](std::size_t i) {
        const auto first = static_cast<unsigned char>(text[i]);
        const auto second = static_cast<unsigned char>(text[i + 1]);
        return order == 0 ? first | second << 8U : first << 8U | second;
    };
    std::string converted;
    for (std::size_t i = 0; i + 1 < text.size(); i += 2) {
        unsigned code = unit(i);
        if (code >= 0xd800 && code < 0xdc00 && i + 3 < text.size() && (unit(i + 2) & 0xfc00) == 0xdc00) {
            code = 0x10000 + ((code & 0x3ff) << 10U) + (unit(i + 2) & 0x3ff);
            i += 2;
        } else if (code >= 0xd800 && code < 0xe000) {
            code = 0xfffd;
        }
        if (code != 0xfeff || i > 0) { // the byte order mark
            append_utf8(converted, code);
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

std::string figure(double value, int significant) {
    if (value == 0.0 || !std::isfinite(value)) {
        return fmt::format("{}", value);
    }
    const int digits = significant - 1 - static_cast<int>(std::floor(std::log10(std::abs(value))));
    return digits < 0   ? fmt::format("{:.0f}", value)
           : digits > 9 ? fmt::format("{:.3e}", value)
                        : fmt::format("{:.{}f}", value, digits);
}

std::string p_words(double p) {
    return p < 1e-6 ? "p < 1e-6" : fmt::format("p = {:.2g}", p);
}

std::string counted(std::size_t count, const std::string& one, const std::string& many) {
    return fmt::format("{} {}", count, count == 1 ? one : many);
}

} // namespace pave
