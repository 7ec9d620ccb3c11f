#include "data/fwd_kuab.h"

#include "data/csv.h"
#include "data/fwd_lines.h"
#include "data/fwd_values.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>

namespace explore::data {
namespace {

// ddmm.mmm (digits_of_degrees = 2) or dddmm.mmm (3) of a satellite receiver, in degrees; nothing: another form.
std::optional<double> receiver_degrees(std::string_view word, std::size_t digits_of_degrees) {
    const bool is_negative = word.starts_with('-');
    word.remove_prefix(is_negative ? 1 : 0);
    if (word.find('.') != digits_of_degrees + 2 || word.size() < digits_of_degrees + 5 ||
        word.find_first_not_of(".0123456789") != std::string_view::npos) {
        return std::nullopt;
    }
    const auto whole = measured(word.substr(0, digits_of_degrees));
    const auto minutes = measured(word.substr(digits_of_degrees));
    return whole && minutes && *minutes < 60.0 ? std::optional((is_negative ? -1.0 : 1.0) * (*whole + *minutes / 60.0))
                                               : std::nullopt;
}

class KuabReader {
public:
    explicit KuabReader(std::string file) : file_(std::move(file)) {}

    // Before the lines are taken: where the positions, or else the time, stand in most lines of drops.
    void look_at(std::string_view line) {
        if (line.starts_with('D')) {
            ++tails_[tail_of(words_of(line.substr(1)))];
        }
    }

    void take(std::string_view line, int number) {
        if (line.empty()) {
            return;
        }
        const std::string_view rest = line.substr(1);
        switch (line[0]) {
        case 'I':
        case 'H': take_header(rest, number); break;
        case 'J': take_names(rest, number); break;
        case 'D': take_drop(words_of(rest), number); break;
        default: break; // comments, time histories
        }
    }

    FwdFile file() && { return with_drops(std::move(result_), file_, "lines such as \"D 200 2 41.5 388 184 ...\""); }

private:
    static std::vector<std::string> lower_words(std::string_view line) {
        std::vector<std::string> words;
        for (const std::string_view word : words_of(line)) {
            words.push_back(lower_case(word));
        }
        return words;
    }

    static bool is_position(const std::vector<std::string_view>& words, std::size_t i) {
        return receiver_degrees(words[i], 2) && i + 1 < words.size() && receiver_degrees(words[i + 1], 3);
    }

    // The number of the word where the position begins, or else the time; of all words where a line has neither.
    static std::size_t tail_of(const std::vector<std::string_view>& words) {
        for (std::size_t i = 0; i < words.size(); ++i) {
            if (is_position(words, i) || words[i].find(':') != std::string_view::npos) {
                return i;
            }
        }
        return words.size();
    }

    std::size_t usual_tail() const {
        return std::max_element(tails_.begin(), tails_.end(),
                                [](const auto& a, const auto& b) { return a.second < b.second; })
            ->first;
    }

    void take_names(std::string_view rest, int line) {
        if (!names_.empty()) {
            units_ = lower_words(rest);
            return;
        }
        names_ = lower_words(rest);
        deflections_ =
            static_cast<std::size_t>(std::count_if(names_.begin(), names_.end(), [](const std::string& name) {
                return name.size() > 1 && name[0] == 'd' &&
                       name.find_first_not_of("0123456789", 1) == std::string::npos;
            }));
        if (deflections_ > 0 && !offsets_mm_.empty() && deflections_ != offsets_mm_.size()) {
            result_.remarks.push_back(
                fmt::format("{}, line {}: {} columns of deflections and {} sensor distances: what "
                            "has no distance is not used",
                            file_, line, deflections_, offsets_mm_.size()));
        }
    }

    void take_header(std::string_view rest, int line) {
        const std::size_t colon = rest.find(':');
        if (colon == std::string_view::npos) {
            return;
        }
        const std::string name = lower_case(trimmed(rest.substr(0, colon)));
        const std::string_view value = trimmed(rest.substr(colon + 1));
        if (name == "plate radius" || name == "sensor distance") {
            auto words = words_of(value);
            const pave::Place place{.file = file_, .line = line, .key = name};
            double to_mm = 10.0; // cm
            if (!words.empty() && words.back().starts_with('(')) {
                std::string_view unit = words.back().substr(1);
                unit = unit.substr(0, unit.find(')'));
                const auto factor = factor_of(length_units(), unit);
                if (!factor) {
                    throw pave::Error(place, "unknown unit", "\"" + std::string(unit) + "\"", names_of(length_units()));
                }
                to_mm = *factor * 1e3;
                words.pop_back();
            }
            std::vector<double> numbers; // not a number: nil
            for (const std::string_view word : words) {
                const auto number = measured_with_comma(word);
                if (!number) {
                    result_.remarks.push_back(
                        fmt::format("{}, line {}, {}: \"{}\" is not a number, and what it is of left out", file_, line,
                                    name, word));
                }
                numbers.push_back(number ? *number * to_mm : NAN);
            }
            if (numbers.empty()) {
                throw pave::Error(place, "no value", {}, "numbers and their unit, as in 15.0 (cm)");
            }
            if (name == "plate radius") {
                radius_mm_ = numbers[0];
            } else {
                offsets_mm_ = numbers;
            }
        } else if (name == "lane") {
            lane_ = value;
        } else if (name.starts_with("date")) {
            date_ = value;
        }
    }

    // Factor to SI of a column, by its unit in the second line J; `otherwise` where that line is not there.
    double unit(std::size_t column, std::span<const NamedUnit> known, double otherwise, int line) const {
        if (column >= units_.size()) {
            return otherwise;
        }
        const auto factor = factor_of(known, units_[column]);
        if (!factor) {
            throw pave::Error({.file = file_, .line = line, .key = column < names_.size() ? names_[column] : "unit"},
                              "unknown unit", "\"" + units_[column] + "\"", names_of(known));
        }
        return *factor;
    }

    void take_drop(const std::vector<std::string_view>& words, int line) {
        const std::size_t n = deflections_ > 0 ? deflections_ : offsets_mm_.size();
        const pave::Place place{.file = file_, .line = line, .key = "drop"};
        if (offsets_mm_.empty() || !radius_mm_) {
            throw pave::Error(place, "a drop before the plate and the places of the sensors", {},
                              "lines \"IPlate Radius\" and \"ISensor Distance\" before it");
        }
        constexpr std::size_t first_deflection = 3; // behind distance, number of the drop, load
        const auto number = [&](std::size_t i) {
            return i < words.size() ? measured_with_comma(words[i]) : std::nullopt;
        };
        const std::string_view where = words.empty() ? std::string_view{} : words[0];
        const auto place_m = chainage(where, unit(0, length_units(), 1.0, line));
        const auto drop_number = number(1);
        const std::size_t tail = tail_of(words);
        const bool is_cut = words.size() < first_deflection + n;
        const std::size_t least = tail < words.size() ? first_deflection + n + 2 : first_deflection + n;
        const bool is_shifted = is_cut || tail < std::max(least, usual_tail());
        auto& stations = result_.stations;
        const bool is_new =
            stations.empty() || stations.back().name != where ||
            (drop_number && !stations.back().drops.empty() && *drop_number <= stations.back().drops.back().number);
        if (is_new) {
            FwdStation station{
                .name = std::string(where), .lane = lane_, .chainage_m = place_m, .date = date_, .file = file_};
            station.line = line;
            if (!place_m) {
                station.remarks.push_back(fmt::format("line {}: \"{}\" is no chainage", line, where));
            }
            const auto temperature = [&](std::size_t i) {
                const auto value = number(i);
                const bool fahrenheit = i < units_.size() && units_[i] == "f";
                return value && fahrenheit ? std::optional(celsius(*value)) : value;
            };
            station.air_C = is_shifted ? std::nullopt : temperature(first_deflection + n);
            station.surface_C = is_shifted ? std::nullopt : temperature(first_deflection + n + 1);
            for (std::size_t i = first_deflection + n + 2; i < words.size(); ++i) {
                if (is_position(words, i)) {
                    set_position(station, receiver_degrees(words[i], 2), receiver_degrees(words[i + 1], 3));
                }
                if (words[i].find(':') != std::string_view::npos) {
                    station.time = words[i];
                }
            }
            stations.push_back(std::move(station));
        }
        FwdStation& station = stations.back();
        FwdDrop drop{.number = drop_number && std::abs(*drop_number) < 1e6 ? static_cast<int>(*drop_number)
                                                                           : static_cast<int>(station.drops.size()) + 1,
                     .radius_mm = *radius_mm_,
                     .pressure_kPa = NAN,
                     .readings = {}};
        drop.line = line;
        if (const auto load = number(2)) {
            if (units_.size() > 2 && factor_of(pressure_units(), units_[2])) {
                drop.pressure_kPa = *load * *factor_of(pressure_units(), units_[2]) / 1e3;
            } else {
                drop.force_kN = *load * unit(2, force_units(), 1e3, line) / 1e3;
                drop.pressure_kPa = plate_pressure_kPa(*drop.force_kN, *radius_mm_);
            }
        }
        if (is_shifted) {
            // Which of its values is missing cannot be told.
            drop.flag = is_cut
                            ? fmt::format("line {} ends after {} values", line, words.size())
                            : fmt::format("line {} has a value less than it should before its position or time", line);
        }
        for (std::size_t i = 0; i < std::min(n, offsets_mm_.size()); ++i) {
            if (!std::isfinite(offsets_mm_[i])) {
                continue;
            }
            if (const auto deflection = number(first_deflection + i)) {
                drop.readings.push_back(
                    {offsets_mm_[i], *deflection * (unit(first_deflection + i, length_units(), 1e-6, line) * 1e6)});
            } else {
                drop.not_read_mm.push_back(offsets_mm_[i]);
            }
        }
        station.drops.push_back(std::move(drop));
    }

    std::string file_;
    std::string lane_, date_;
    std::optional<double> radius_mm_;
    std::vector<double> offsets_mm_;
    std::vector<std::string> names_, units_; // of the columns; may be empty
    std::size_t deflections_ = 0;            // columns of them by these names; 0: not named
    std::map<std::size_t, int> tails_;       // lines, by where their positions or times stand
    FwdFile result_;
};

} // namespace

bool recognises_fwd_kuab(std::string_view text, const ColumnMap& /*columns*/) {
    const std::size_t begin = text.find_first_not_of(" \t\r\n");
    return begin != std::string_view::npos && lower_case(text.substr(begin, 14)) == "ikuab fwd file";
}

FwdFile read_fwd_kuab(std::string_view text, const std::string& file, const ColumnMap& /*columns*/) {
    KuabReader reader(file);
    for_each_line(text, [&](std::string_view line, int /*number*/) { reader.look_at(line); });
    for_each_line(text, [&](std::string_view line, int number) { reader.take(line, number); });
    return std::move(reader).file();
}

} // namespace explore::data
