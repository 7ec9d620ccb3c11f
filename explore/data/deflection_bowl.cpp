#include "data/deflection_bowl.h"

#include "data/bowl_sensors.h"
#include "data/drop_levels.h"
#include "data/fwd_values.h"
#include "data/plausibility.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <numbers>
#include <set>

namespace explore::data {
namespace {

constexpr double near_target = 0.15;     // of the target
constexpr double drops_contradict = 0.5; // scatter of the logarithms of a sensor's readings
constexpr double sides_disagree = 0.1;   // deflections ahead of and behind the plate: worth a remark
constexpr double dead_um = 1.0;          // half of what a sensor resolves
constexpr double full_bowl_mm = 600.0;   // where a bowl has fallen
constexpr double accuracy_um = 2.0;      // of a sensor, and
constexpr double accuracy_share = 0.02;  // of what it reads

double accuracy(double deflection_um) {
    return accuracy_um + accuracy_share * deflection_um;
}

// Reads the drops of a station, step by step. Each step may find why nothing can be made of it.
class Making {
public:
    Making(const FwdStation& station, const DropChoice& choice)
        : station_(station),
          choice_(choice),
          scatter_(choice.scatter.value_or(RepeatScatter{})) {
        scatter_.resolution_um = choice.resolution_um;
    }

    pave::Outcome<StationBowls> bowls() && {
        const auto rejected = [](std::string reason) { return pave::Failure{.reason = std::move(reason)}; };
        if (std::string reason = choose_drops(); !reason.empty()) {
            return rejected(std::move(reason));
        }
        for (std::size_t i = 0; i < levels_.size(); ++i) {
            auto bowl = bowl_of(levels_[i]);
            if (bowl) {
                main_ = i == chosen_ ? std::optional(result_.levels.size()) : main_;
                result_.levels.push_back(std::move(*bowl));
            } else if (i == chosen_) {
                return rejected(reason_with_sensors());
            } else {
                for (const FwdDrop* d : levels_[i]) {
                    result_.left_out.push_back({d->number, LeftOut::implausible, reason_});
                }
            }
        }
        result_.main = *main_;
        result_.doubt = doubtful(*levels_[chosen_][0]);
        if (!result_.doubt.empty()) {
            remark(result_.doubt);
        }
        return std::move(result_);
    }

private:
    // Sensors that were left out may be why.
    std::string reason_with_sensors() const {
        std::string words = reason_;
        for (const std::string& remark : result_.remarks) {
            words += remark.ends_with("is left out") || remark.ends_with("no reading here") ? "; " + remark : "";
        }
        return words;
    }

    // Fills levels_ and chosen_. Returns why there is nothing to choose, or "".
    std::string choose_drops() {
        if (!station_.unusable.empty()) {
            return station_.unusable;
        }
        std::vector<const FwdDrop*> drops;
        std::set<int> numbers;
        std::string first_reason;
        for (const FwdDrop& d : station_.drops) {
            if (!numbers.insert(d.number).second) {
                return fmt::format("drop {} appears twice", d.number);
            }
            if (!choice_.numbers.empty() &&
                std::find(choice_.numbers.begin(), choice_.numbers.end(), d.number) == choice_.numbers.end()) {
                result_.left_out.push_back({d.number, LeftOut::not_chosen, {}});
                continue;
            }
            const std::string doubt = implausible(d);
            if (!d.flag.empty() || !doubt.empty()) {
                const bool flagged = !d.flag.empty();
                result_.left_out.push_back(
                    {d.number, flagged ? LeftOut::flagged : LeftOut::implausible, flagged ? d.flag : doubt});
                first_reason = first_reason.empty() ? fmt::format("drop {}: {}", d.number, flagged ? d.flag : doubt)
                                                    : first_reason;
                continue;
            }
            drops.push_back(&d);
        }
        if (drops.empty()) {
            return !first_reason.empty()    ? first_reason
                   : station_.drops.empty() ? "it has no drops"
                                            : "it has none of the drops that are requested";
        }
        for (const FwdDrop* d : drops) {
            if (d->radius_mm != drops[0]->radius_mm) {
                return fmt::format("plates of radius {:g} and {:g} mm", drops[0]->radius_mm, d->radius_mm);
            }
        }
        if (choice_.numbers.empty() &&
            first_is_seating(drops, choice_.first_of_two_seats, choice_.scatter ? scatter_.at(0.0) : 0.0,
                             choice_.resolution_um)) {
            result_.left_out.push_back({drops[0]->number, LeftOut::seating, {}});
            seating_ = drops[0];
            drops.erase(drops.begin());
        }
        levels_ = levels_of(std::move(drops));
        if (choice_.numbers.empty()) {
            take_out_misread_loads();
        }
        chosen_ = levels_.size() - 1;
        return choose_level();
    }

    std::string choose_level() {
        const double radius_mm = levels_[0][0]->radius_mm;
        std::optional<double> target = choice_.target_pressure_kPa;
        if (choice_.target_force_kN) {
            target = plate_pressure_kPa(*choice_.target_force_kN, radius_mm);
        }
        if (!target) {
            return {};
        }
        double nearest = INFINITY;
        double found = 0.0;
        for (std::size_t i = 0; i < levels_.size(); ++i) {
            const double pressure = pressure_of(levels_[i]);
            const double distance = std::abs(std::log(pressure / *target));
            if (distance < nearest) {
                nearest = distance;
                found = pressure;
                chosen_ = i;
            }
        }
        const auto is_near = [&](double pressure) { return std::abs(pressure / *target - 1.0) <= near_target; };
        if (is_near(found)) {
            return {};
        }
        if (seating_ != nullptr && is_near(seating_->pressure_kPa)) {
            return fmt::format(
                "no drop near {:.0f} kPa but drop {}, which seats the plate (--drops {} takes it): of the "
                "others the nearest has {:.0f} kPa",
                *target, seating_->number, seating_->number, found);
        }
        return fmt::format("no drop near {:.0f} kPa: the nearest has {:.0f} kPa", *target, found);
    }

    // Nothing: reason_ says why.
    std::optional<DeflectionBowl> bowl_of(const Level& level) {
        DeflectionBowl bowl;
        bowl.radius_mm = level[0]->radius_mm;
        bowl.pressure_kPa = pressure_of(level);
        LevelReadings read = readings_of(level);
        std::set<double> not_read;
        for (const FwdDrop* d : level) {
            not_read.insert(d->not_read_mm.begin(), d->not_read_mm.end());
        }
        remark_on_silent(read, not_read, level.size());
        if (!read.empty() && std::all_of(read.begin(), read.end(),
                                         [](const auto& at) { return median(deflections_of(at.second)) < 0.0; })) {
            reason_ = "every deflection is negative: the sign is turned (positive is down)";
            return std::nullopt;
        }
        const Level agreeing = agreeing_drops(level, read);
        // At the pressure of the drops that are left.
        const double factor = pressure_of(agreeing) / bowl.pressure_kPa;
        bowl.pressure_kPa *= factor;
        for (const FwdDrop* d : agreeing) {
            bowl.drops.push_back(d->number);
        }
        std::set<double> disagreeing;
        for (const Disagreement& d : disagreements(read, scatter_)) {
            disagreeing.insert(d.offset_mm);
            result_.disagreements.push_back(d);
        }
        std::map<double, BowlReading> ahead;
        std::map<double, BowlReading> behind; // by distance
        for (const auto& [offset, readings] : read) {
            BowlReading r = reading(offset, deflections_of(readings), factor);
            r.disagrees = disagreeing.contains(offset);
            (offset < 0.0 ? behind : ahead)[std::abs(offset)] = r;
        }
        take_out_dead(ahead, 1.0);
        take_out_dead(behind, -1.0);
        compare_sides(ahead, behind);
        for (const auto& [offset, r] : ahead) {
            bowl.readings.push_back(r);
        }
        if (bowl.readings.empty() || bowl.readings[0].offset_mm != 0.0) {
            reason_ = "no reading at the centre of the load (D0)";
            return std::nullopt;
        }
        if (!falls(bowl)) {
            return std::nullopt;
        }
        remark_on_disagreement();
        return bowl;
    }

    static std::vector<double> deflections_of(const std::vector<LevelReading>& readings) {
        std::vector<double> um;
        um.reserve(readings.size());
        std::transform(readings.begin(), readings.end(), std::back_inserter(um),
                       [](const LevelReading& r) { return r.um; });
        return um;
    }

    void remark_on_silent(const LevelReadings& read, const std::set<double>& not_read, std::size_t drops) {
        std::vector<std::string> silent;
        for (const double offset : not_read) {
            if (!read.contains(offset)) {
                silent.push_back(fmt::format("{:g}", offset));
            }
        }
        if (!silent.empty()) {
            remark(fmt::format("{} at {} mm gave no reading here", silent.size() == 1 ? "the sensor" : "the sensors",
                               pave::join(silent)));
        }
        for (const auto& [offset, readings] : read) {
            if (readings.size() < drops) {
                remark(fmt::format("the sensor at {:g} mm was read in {} of {} drops", offset, readings.size(), drops));
            }
        }
    }

    // Without the drops and the readings that their repeats contradict.
    Level agreeing_drops(const Level& level, LevelReadings& read) {
        if (choice_.keeps_contradicted) {
            return level;
        }
        Level left = level;
        if (choice_.numbers.empty()) {
            for (const ContradictedDrop& out : take_out_drops(read, scatter_)) {
                result_.left_out.push_back(
                    {out.drop, LeftOut::contradicted,
                     fmt::format("its repeats contradict it, deflection over pressure {:+.0f} %", 100.0 * out.share)});
                std::erase_if(left, [&](const FwdDrop* d) { return d->number == out.drop; });
            }
        }
        for (const ContradictedReading& out : take_out_readings(read, scatter_)) {
            remark(
                fmt::format("the sensor at {:g} mm in drop {} reads {:.1f} um, its repeats {:.1f} um: it is left out",
                            out.offset_mm, out.drop, out.read_um, out.repeats_um));
            result_.readings_left_out.push_back(out);
        }
        std::vector<LevelCompliance> others;
        for (const Level& other : levels_) {
            if (other != level) {
                others.push_back(compliance_of(readings_of(other), pressure_of(other)));
            }
        }
        for (const ContradictedReading& out : take_out_by_levels(read, pressure_of(level), others, scatter_)) {
            remark(fmt::format("the sensor at {:g} mm in drop {} reads {:.1f} um, where its readings under the other "
                               "loads call for {:.1f} um: it is left out",
                               out.offset_mm, out.drop, out.read_um, out.repeats_um));
            result_.readings_left_out.push_back(out);
        }
        return left;
    }

    void take_out_misread_loads() {
        for (const MisreadLoad& out : data::take_out_misread_loads(levels_)) {
            for (const FwdDrop* d : out.drops) {
                result_.left_out.push_back(
                    {d->number, LeftOut::contradicted,
                     fmt::format("it states {:.0f} kPa, but its deflections are those of {} "
                                 "under {:.0f} kPa",
                                 d->pressure_kPa, drops_words(out.twin), pressure_of(out.twin))});
            }
        }
    }
    static std::string drops_words(const Level& level) {
        std::vector<std::string> numbers;
        for (const FwdDrop* d : level) {
            numbers.push_back(std::to_string(d->number));
        }
        return fmt::format("{} {}", numbers.size() == 1 ? "drop" : "drops", pave::join(numbers));
    }

    // The mean of the drops; factor: to the pressure of the bowl.
    BowlReading reading(double offset, const std::vector<double>& deflections, double factor) const {
        const auto n = static_cast<double>(deflections.size());
        BowlReading r{.offset_mm = std::abs(offset), .drops = static_cast<int>(deflections.size())};
        for (const double d : deflections) {
            r.deflection_um += factor * d / n;
        }
        r.resolution_um = choice_.resolution_um;
        if (deflections.size() > 1 &&
            std::all_of(deflections.begin(), deflections.end(), [](double d) { return d > 0.0; })) {
            double mean = 0.0;
            double squares = 0.0;
            for (const double d : deflections) {
                mean += std::log(d) / n;
            }
            for (const double d : deflections) {
                squares += std::pow(std::log(d) - mean, 2);
            }
            r.scatter = std::sqrt(squares / (n - 1.0));
        }
        return r;
    }

    // side: -1 behind the plate, for words.
    void take_out(std::map<double, BowlReading>& readings, double offset, double side, const char* why) {
        const BowlReading& r = readings.at(offset);
        remark(fmt::format("the sensor at {:g} mm reads {:.1f} um{}, {}, and is left out",
                           offset == 0.0 ? 0.0 : side * offset, r.deflection_um,
                           r.scatter.value_or(0.0) > drops_contradict ? ", in drops that contradict each other" : "",
                           why));
        readings.erase(offset);
    }

    void take_out_dead(std::map<double, BowlReading>& readings, double side) {
        std::vector<double> dead;
        for (const auto& [offset, r] : readings) {
            if (r.deflection_um < dead_um) {
                dead.push_back(offset);
            }
        }
        for (const double offset : dead) {
            take_out(readings, offset, side, "next to nothing");
        }
        while (const auto culprit = most_contradicted(readings)) {
            take_out(readings, *culprit, side, "which the sensors beside it contradict");
        }
    }

    void compare_sides(std::map<double, BowlReading>& ahead, const std::map<double, BowlReading>& behind) {
        for (const auto& [distance, r] : behind) {
            const auto same = ahead.find(distance);
            if (same != ahead.end()) {
                const double gap = std::abs(same->second.deflection_um - r.deflection_um);
                if (gap > 2.0 * accuracy_um + sides_disagree * std::max(same->second.deflection_um, r.deflection_um)) {
                    remark(fmt::format("the sensor at {:g} mm reads {:.1f} um, the one at {:g} mm {:.1f} um: the one "
                                       "ahead of the plate is used",
                                       -distance, r.deflection_um, distance, same->second.deflection_um));
                }
                continue;
            }
            const auto outer = ahead.upper_bound(distance);
            const bool fits = outer != ahead.begin() && std::prev(outer)->second.deflection_um >= r.deflection_um &&
                              (outer == ahead.end() || outer->second.deflection_um <= r.deflection_um);
            remark(fmt::format("there is no reading at {:g} mm: the one at {:g} mm, {:.1f} um, {}", distance, -distance,
                               r.deflection_um,
                               fits ? "stands in" : "does not fit between its neighbours and is left out"));
            if (fits) {
                ahead.emplace(distance, r);
            }
        }
    }

    // Whether the deflections fall outwards, or may; else reason_ says where not.
    bool falls(DeflectionBowl& bowl) {
        for (std::size_t i = 1; i < bowl.readings.size(); ++i) {
            const BowlReading& inner = bowl.readings[i - 1];
            const BowlReading outer = bowl.readings[i];
            if (outer.deflection_um <= inner.deflection_um) {
                continue;
            }
            const std::string words = fmt::format(
                "the deflection rises from {:.{}f} um at {:g} mm to {:.{}f} um at {:g} mm", inner.deflection_um,
                digits(inner), inner.offset_mm, outer.deflection_um, digits(outer), outer.offset_mm);
            const bool may_be = outer.deflection_um - inner.deflection_um <=
                                accuracy(inner.deflection_um) + accuracy(outer.deflection_um);
            if (may_be) {
                remark(words + ", within what the sensors are good to");
            } else if (i + 1 == bowl.readings.size() && i > 1) {
                remark(words + ": the last sensor is left out");
                bowl.readings.pop_back();
            } else {
                reason_ = words;
                return false;
            }
        }
        const BowlReading& last = bowl.readings.back();
        if (last.offset_mm >= full_bowl_mm && bowl.readings.size() > 2 &&
            last.deflection_um >= (1.0 - accuracy_share) * bowl.d0_um()) {
            reason_ =
                fmt::format("the deflection does not fall: {:.{}f} um at the centre and {:.{}f} um at {:g} mm",
                            bowl.d0_um(), digits(bowl.readings[0]), last.deflection_um, digits(last), last.offset_mm);
            return false;
        }
        for (std::string& words : faint_sensors(bowl.readings)) {
            remark(std::move(words));
        }
        return true;
    }

    static int digits(const BowlReading& r) { return r.deflection_um < 100.0 ? 1 : 0; }

    // The worst of the level that was just made.
    void remark_on_disagreement() {
        const auto worst = std::max_element(
            result_.disagreements.begin() + static_cast<std::ptrdiff_t>(disagreements_said_),
            result_.disagreements.end(), [](const auto& a, const auto& b) { return a.share < b.share; });
        if (worst != result_.disagreements.end()) {
            remark(fmt::format("the drops disagree by {:.0f} % at {:g} mm ({:.1f} to {:.1f} um)", 100.0 * worst->share,
                               worst->offset_mm, worst->low_um, worst->high_um));
        }
        disagreements_said_ = result_.disagreements.size();
    }

    void remark(std::string words) {
        if (std::find(result_.remarks.begin(), result_.remarks.end(), words) == result_.remarks.end()) {
            result_.remarks.push_back(std::move(words));
        }
    }

    const FwdStation& station_;
    const DropChoice& choice_;
    RepeatScatter scatter_;
    std::size_t disagreements_said_ = 0;
    const FwdDrop* seating_ = nullptr; // that was left out
    std::vector<Level> levels_;
    std::size_t chosen_ = 0;
    std::optional<std::size_t> main_; // of result_.levels
    std::string reason_;
    StationBowls result_;
};

} // namespace

bool DeflectionBowl::has_sensor_at(double offset_mm) const {
    return std::any_of(readings.begin(), readings.end(),
                       [&](const BowlReading& r) { return r.offset_mm == offset_mm; });
}

std::optional<double> DeflectionBowl::at(double offset_mm) const {
    const auto above =
        std::find_if(readings.begin(), readings.end(), [&](const BowlReading& r) { return r.offset_mm >= offset_mm; });
    if (above == readings.end()) {
        return std::nullopt;
    }
    if (above->offset_mm == offset_mm) {
        return above->deflection_um;
    }
    if (above == readings.begin() || (above - 1)->offset_mm <= radius_mm) {
        return std::nullopt;
    }
    const BowlReading& below = *(above - 1);
    const double t = (offset_mm - below.offset_mm) / (above->offset_mm - below.offset_mm);
    return below.deflection_um * std::pow(above->deflection_um / below.deflection_um, t);
}

std::optional<double> DeflectionBowl::deflection_ratio() const {
    const auto d250 = at(ratio_offset_mm);
    return d250 ? std::optional(*d250 / d0_um()) : std::nullopt;
}

double DeflectionBowl::force_kN() const {
    return pressure_kPa * std::numbers::pi * radius_mm * radius_mm * 1e-6;
}

pave::Outcome<StationBowls> bowls_of(const FwdStation& station, const DropChoice& choice) {
    return Making(station, choice).bowls();
}

std::optional<double> repeatability(const std::vector<const DeflectionBowl*>& bowls) {
    double squares = 0.0;
    double degrees = 0.0;
    for (const DeflectionBowl* bowl : bowls) {
        for (const BowlReading& r : bowl->readings) {
            if (r.scatter && !r.disagrees) {
                const double rounding = r.resolution_um / r.deflection_um;
                squares += (*r.scatter * *r.scatter - rounding * rounding / 12.0) * (r.drops - 1);
                degrees += r.drops - 1;
            }
        }
    }
    return degrees > 0.0 ? std::optional(std::sqrt(std::max(0.0, squares) / degrees)) : std::nullopt;
}

} // namespace explore::data
