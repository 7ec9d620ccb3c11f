// Going through a text line by line, and through a line.
#pragma once

#include "data/csv.h"

#include <algorithm>
#include <string_view>
#include <vector>

namespace explore::data {

// Calls take(line, number) for every line, without its end; numbers from 1.
template <class Take>
void for_each_line(std::string_view text, const Take& take) {
    for (int number = 1; !text.empty(); ++number) {
        const std::size_t end = text.find('\n');
        std::string_view line = text.substr(0, end);
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
        if (line.ends_with('\r')) {
            line.remove_suffix(1);
        }
        take(line, number);
    }
}

// Cells between separators, without the blanks around them; one more than there are separators.
inline std::vector<std::string_view> cells_between(char separator, std::string_view line) {
    std::vector<std::string_view> cells;
    for (;;) {
        const std::size_t end = line.find(separator);
        cells.push_back(trimmed(line.substr(0, end)));
        if (end == std::string_view::npos) {
            return cells;
        }
        line.remove_prefix(end + 1);
    }
}

// Words between blanks and tabs.
inline std::vector<std::string_view> words_of(std::string_view line) {
    std::vector<std::string_view> words;
    for (;;) {
        const std::size_t begin = line.find_first_not_of(" \t");
        if (begin == std::string_view::npos) {
            return words;
        }
        const std::size_t end = std::min(line.find_first_of(" \t", begin), line.size());
        words.push_back(line.substr(begin, end - begin));
        line.remove_prefix(end);
    }
}

} // namespace explore::data
