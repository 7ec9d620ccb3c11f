#include "data/fwd_values.h"

#include "base/error.h"
#include "data/csv.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <vector>

namespace explore::data {
namespace {

constexpr double pound_force = 4.4482216152605;
constexpr double psi = 6894.757293168;

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

// Digits with at most one point, as one number; nothing: something else.
std::optional<double> plain_decimal(std::string_view text) {
    const bool digits = std::all_of(text.begin(), text.end(), [](char c) { return is_digit(c) || c == '.'; });
    return digits ? number_or_nothing(text) : std::nullopt;
}

} // namespace

bool is_nil(std::string_view cell) {
    static constexpr std::array<std::string_view, 24> nils = {
        "",     "-",    "--",   "---",     "n0",    "no",      "n/a",    "n.a.",  "na",     "nan",     "inf", "-inf",
        "null", "none", "#n/a", "#value!", "#ref!", "#div/0!", "#name?", "#num!", "#null!", "missing", "?",   "*"};
    return std::find(nils.begin(), nils.end(), lower_case(trimmed(cell))) != nils.end();
}

std::optional<double> measured(std::string_view cell) {
    cell = trimmed(cell);
    if (cell.size() > 1 && cell[0] == '+' && cell[1] != '-' && cell[1] != '+') {
        cell.remove_prefix(1);
    }
    return number_or_nothing(cell);
}

std::optional<double> measured_with_comma(std::string_view cell) {
    std::string text(cell);
    std::replace(text.begin(), text.end(), ',', '.');
    return measured(text);
}

double plate_pressure_kPa(double force_kN, double radius_mm) {
    return force_kN / (std::numbers::pi * radius_mm * radius_mm) * 1e6;
}

std::optional<double> chainage(std::string_view cell, double to_m) {
    cell = trimmed(cell);
    if (const auto plain = measured(cell)) {
        return *plain * to_m;
    }
    // Letters that name the kind of the place: K, ZK, DK, PK, km, Sta.
    while (!cell.empty() && !is_digit(cell[0]) && cell[0] != '+') {
        const auto c = static_cast<unsigned char>(cell[0]);
        if (!(std::isalpha(c) != 0 || c >= 0x80 || c == ' ' || c == '.' || c == ':')) {
            return std::nullopt;
        }
        cell.remove_prefix(1);
    }
    const std::size_t plus = cell.find('+');
    if (plus == std::string_view::npos || plus == 0) {
        return std::nullopt;
    }
    const auto before = plain_decimal(trimmed(cell.substr(0, plus)));
    const auto after = plain_decimal(trimmed(cell.substr(plus + 1)));
    if (!before || !after) {
        return std::nullopt;
    }
    const double whole = to_m == foot_m ? 100.0 : 1000.0;
    if (*after >= whole) {
        return std::nullopt; // "12+1340": one of the two is wrong
    }
    return to_m == foot_m ? (whole * *before + *after) * foot_m : whole * *before + *after;
}

std::optional<double> degrees(std::string_view text) {
    text = trimmed(text);
    double sign = 1.0;
    const auto take_hemisphere = [&](std::size_t at) {
        const char letter = static_cast<char>(std::toupper(static_cast<unsigned char>(text[at])));
        const bool is_one = letter == 'N' || letter == 'E' || letter == 'S' || letter == 'W';
        if (is_one) {
            sign = letter == 'S' || letter == 'W' ? -1.0 : 1.0;
            text = trimmed(at == 0 ? text.substr(1) : text.substr(0, at));
        }
        return is_one;
    };
    if (!text.empty() && !take_hemisphere(text.size() - 1)) {
        take_hemisphere(0);
    }
    if (const auto decimal = measured(text)) {
        return sign * *decimal;
    }
    if (text.starts_with('-')) {
        sign = -sign;
        text.remove_prefix(1);
    }
    // Degrees, minutes and seconds, whatever stands between them.
    std::vector<double> parts;
    for (std::size_t i = 0; i < text.size();) {
        if (!is_digit(text[i])) {
            if (text[i] == '-') {
                return std::nullopt;
            }
            ++i;
            continue;
        }
        std::size_t end = i;
        while (end < text.size() && (is_digit(text[end]) || text[end] == '.')) {
            ++end;
        }
        const auto part = number_or_nothing(text.substr(i, end - i));
        if (!part) {
            return std::nullopt;
        }
        parts.push_back(*part);
        i = end;
    }
    if (parts.empty() || parts.size() > 3) {
        return std::nullopt;
    }
    parts.resize(3, 0.0);
    return parts[1] < 60.0 && parts[2] < 60.0 ? std::optional(sign * (parts[0] + parts[1] / 60.0 + parts[2] / 3600.0))
                                              : std::nullopt;
}

std::optional<double> hour_of_day(std::string_view time) {
    std::string words = lower_case(trimmed(time));
    double noon = 0.0; // hours that "pm" adds, and "am" takes from twelve
    bool is_twelve_hours = false;
    bool has_word = false;
    for (const std::string_view word : {"a.m.", "p.m.", "am", "pm", "uhr", "z", "h"}) {
        if (!has_word && words.size() > word.size() && words.ends_with(word)) {
            has_word = true;
            is_twelve_hours = word.find('m') != std::string_view::npos;
            noon = word.starts_with('p') ? 12.0 : 0.0;
            words = trimmed(std::string_view(words).substr(0, words.size() - word.size()));
        }
    }
    if (const std::size_t date = words.find_last_of(" t"); date != std::string::npos) {
        words.erase(0, date + 1);
    }
    if (const auto number = number_or_nothing(words); number && words.find('.') != std::string::npos && !has_word) {
        // A spreadsheet's number: days, of which the rest is the time.
        constexpr double first_day = 20000.0;
        return (*number >= 0.0 && *number < 1.0) || *number > first_day
                   ? std::optional(24.0 * (*number - std::floor(*number)))
                   : std::nullopt;
    }
    if (words.find(':') == std::string::npos) {
        std::replace(words.begin(), words.end(), has_word ? '.' : 'h', ':');
    }
    time = words;
    std::optional<double> hours;
    std::optional<double> minutes;
    double seconds = 0.0;
    if (const std::size_t colon = time.find(':'); colon != std::string_view::npos) {
        std::string_view rest = time.substr(colon + 1);
        const std::size_t second = rest.find(':');
        hours = plain_decimal(trimmed(time.substr(0, colon)));
        minutes = plain_decimal(trimmed(rest.substr(0, second)));
        seconds =
            second == std::string_view::npos ? 0.0 : plain_decimal(trimmed(rest.substr(second + 1))).value_or(0.0);
    } else if ((time.size() == 3 || time.size() == 4) && std::all_of(time.begin(), time.end(), is_digit)) {
        hours = plain_decimal(time.substr(0, time.size() - 2));
        minutes = plain_decimal(time.substr(time.size() - 2));
    }
    if (is_twelve_hours && hours) {
        hours = *hours >= 1.0 && *hours < 13.0 ? std::optional(std::fmod(*hours, 12.0) + noon) : std::nullopt;
    }
    if (!hours || !minutes || *hours >= 24.0 || *minutes >= 60.0 || seconds >= 60.0) {
        return std::nullopt;
    }
    return *hours + *minutes / 60.0 + seconds / 3600.0;
}

std::string plain_word(std::string_view text) {
    std::string out;
    for (const char c : lower_case(text)) {
        if (std::string_view(" -_.,:").find(c) == std::string_view::npos) {
            out += c;
        }
    }
    if (out.size() > 3 && out.ends_with('s')) {
        out.pop_back();
    }
    return out;
}

std::span<const NamedUnit> length_units() {
    static constexpr NamedUnit all[] = {
        {"millimeter", 1e-3}, {"millimetre", 1e-3}, {"mm", 1e-3},     {"centimeter", 1e-2}, {"centimetre", 1e-2},
        {"cm", 1e-2},         {"meter", 1.0},       {"metre", 1.0},   {"m", 1.0},           {"kilometer", 1e3},
        {"kilometre", 1e3},   {"km", 1e3},          {"inch", 0.0254}, {"inche", 0.0254},    {"in", 0.0254},
        {"foot", foot_m},     {"feet", foot_m},     {"ft", foot_m},   {"yard", 0.9144},     {"yd", 0.9144},
        {"mile", 1609.344},   {"mi", 1609.344},     {"micron", 1e-6}, {"micrometer", 1e-6}, {"micrometre", 1e-6},
        {"um", 1e-6},         {"µm", 1e-6},         {"μm", 1e-6},     {"my", 1e-6},         {"mu", 1e-6},
        {"mil", 25.4e-6},     {"0.01mm", 1e-5},     {"001mm", 1e-5},  {"1/100mm", 1e-5}};
    return all;
}

std::span<const NamedUnit> force_units() {
    static constexpr NamedUnit all[] = {{"newton", 1.0},
                                        {"n", 1.0},
                                        {"kilonewton", 1e3},
                                        {"kn", 1e3},
                                        {"poundforce", pound_force},
                                        {"poundsforce", pound_force},
                                        {"pound", pound_force},
                                        {"lbf", pound_force},
                                        {"lb", pound_force},
                                        {"lbs", pound_force},
                                        {"kip", 1e3 * pound_force},
                                        {"kgf", 9.80665},
                                        {"kilogramforce", 9.80665},
                                        {"tf", 9806.65},
                                        {"t", 9806.65},
                                        {"ton", 9806.65},
                                        {"tonne", 9806.65},
                                        {"metricton", 9806.65}};
    return all;
}

std::span<const NamedUnit> pressure_units() {
    static constexpr NamedUnit all[] = {{"pascal", 1.0},
                                        {"pa", 1.0},
                                        {"kilopascal", 1e3},
                                        {"kpa", 1e3},
                                        {"megapascal", 1e6},
                                        {"mpa", 1e6},
                                        {"psi", psi},
                                        {"poundspersquareinch", psi},
                                        {"poundpersquareinch", psi},
                                        {"bar", 1e5},
                                        {"kgf/cm2", 98066.5},
                                        {"kg/cm2", 98066.5},
                                        {"kn/m2", 1e3},
                                        {"kn/m²", 1e3},
                                        {"n/mm2", 1e6},
                                        {"n/mm²", 1e6}};
    return all;
}

namespace {

// Parts of a millimetre as tables write them, without blanks, points and hyphens: "0.001 mm", "x 10-2 mm", "mm/100".
std::optional<double> part_of_mm(std::string_view name) {
    for (const std::string_view times : {"x", "×", "*"}) {
        name = name.starts_with(times) ? name.substr(times.size()) : name;
    }
    static constexpr NamedUnit all[] = {{"102mm", 1e-5},   {"10^2mm", 1e-5},   {"10⁻²mm", 1e-5}, {"mm/100", 1e-5},
                                        {"cmm", 1e-5},     {"103mm", 1e-6},    {"10^3mm", 1e-6}, {"10⁻³mm", 1e-6},
                                        {"mm/1000", 1e-6}, {"1/1000mm", 1e-6}, {"0001mm", 1e-6}};
    const auto at = std::find_if(std::begin(all), std::end(all), [&](const NamedUnit& u) { return u.name == name; });
    return at == std::end(all) ? std::nullopt : std::optional(at->to_si);
}

} // namespace

std::optional<double> factor_of(std::span<const NamedUnit> units, std::string_view word) {
    const std::string name = plain_word(word);
    const auto at = std::find_if(units.begin(), units.end(), [&](const NamedUnit& unit) { return unit.name == name; });
    if (at != units.end()) {
        return at->to_si;
    }
    return units.data() == length_units().data() ? part_of_mm(name) : std::nullopt;
}

std::string names_of(std::span<const NamedUnit> units) {
    std::vector<std::string> names;
    for (const NamedUnit& unit : units) {
        names.emplace_back(unit.name);
    }
    return pave::join(names);
}

} // namespace explore::data
