#include "report/table.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::report {

std::size_t width(const std::string& text) {
    return static_cast<std::size_t>(std::count_if(
        text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U; }));
}

namespace {

bool is_numeric(const std::string& text) {
    return !text.empty() && text.find_first_not_of("+-.0123456789e%<>~ inf") == std::string::npos;
}

} // namespace

std::string Table::text(int indent) const {
    std::vector<std::size_t> widths;
    std::vector<bool> right;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
        widths.resize(std::max(widths.size(), rows_[r].size()));
        right.resize(widths.size(), rows_.size() > 1);
        for (std::size_t c = 0; c < rows_[r].size(); ++c) {
            widths[c] = std::max(widths[c], width(rows_[r][c]));
            right[c] = right[c] && (r == 0 || rows_[r][c].empty() || is_numeric(rows_[r][c]));
        }
    }
    std::string all;
    for (const auto& row : rows_) {
        std::string line(static_cast<std::size_t>(indent), ' ');
        for (std::size_t c = 0; c < row.size(); ++c) {
            const std::string pad(widths[c] - width(row[c]), ' ');
            line += (c == 0 ? "" : "  ") + (right[c] ? pad + row[c] : row[c] + pad);
        }
        line.erase(line.find_last_not_of(' ') + 1);
        all += line + "\n";
    }
    return all;
}

std::string sparkline(const std::vector<double>& values) {
    static const char* const blocks[] = {"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
    double low = INFINITY;
    double high = -INFINITY;
    for (const double v : values) {
        if (std::isfinite(v)) {
            low = std::min(low, v);
            high = std::max(high, v);
        }
    }
    std::string text;
    for (const double v : values) {
        if (!std::isfinite(v)) {
            text += " ";
        } else {
            text += blocks[high > low ? std::min(7, static_cast<int>(8.0 * (v - low) / (high - low))) : 0];
        }
    }
    return text;
}

} // namespace explore::report
