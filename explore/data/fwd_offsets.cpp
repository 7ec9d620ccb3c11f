#include "data/fwd_offsets.h"

#include "data/csv.h"
#include "data/fwd_values.h"

namespace explore::data {
namespace {

constexpr std::string_view deflection_words[] = {"deflection", "defl", "def", "df", "d", "w"};

} // namespace

std::optional<double> sensor_offset_mm(std::string_view base) {
    std::string text;
    for (const char c : lower_case(base)) {
        if (std::string_view(" _(),:").find(c) == std::string_view::npos) {
            text += c;
        }
    }
    for (const std::string_view word : deflection_words) {
        if (!text.starts_with(word)) {
            continue;
        }
        const std::string_view rest = std::string_view(text).substr(word.size());
        const std::size_t digits = rest.find_first_not_of("-.0123456789");
        const auto number = number_or_nothing(rest.substr(0, digits));
        if (!number) {
            continue;
        }
        if (digits == std::string_view::npos) {
            return number;
        }
        const auto unit = factor_of(length_units(), rest.substr(digits));
        return unit ? std::optional(*number * *unit * 1e3) : std::nullopt;
    }
    return std::nullopt;
}

double offset_unit_mm(const std::vector<std::string>& row) {
    for (const std::string& cell : row) {
        const std::string_view text = trimmed(cell);
        const std::size_t open = text.find_first_of("([_");
        if (open != std::string_view::npos && text.size() > open + 1) {
            std::string_view word = text.substr(open + 1);
            word = word.substr(0, word.find_first_of(")]"));
            if (const auto unit = factor_of(length_units(), word)) {
                return *unit * 1e3;
            }
        }
    }
    return 1.0;
}

std::optional<double> place_mm(std::string_view cell, double unit_mm) {
    if (const auto number = measured(cell)) {
        return unit_mm * *number;
    }
    const std::size_t end = cell.find_first_not_of("+-.0123456789 ");
    const auto number = end == std::string_view::npos ? std::nullopt : measured(trimmed(cell.substr(0, end)));
    const auto unit = number ? factor_of(length_units(), cell.substr(end)) : std::nullopt;
    return unit ? std::optional(*number * *unit * 1e3) : std::nullopt;
}

bool is_deflection_in_another_unit(std::string_view name) {
    for (const char separator : {'(', '[', '_', ' '}) {
        const std::size_t at = name.rfind(separator);
        if (at != std::string_view::npos && at > 0 && sensor_offset_mm(trimmed(name.substr(0, at)))) {
            return true;
        }
    }
    return false;
}

} // namespace explore::data
