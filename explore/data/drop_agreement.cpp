#include "data/drop_agreement.h"

#include "data/median.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <set>

namespace explore::data {
namespace {

constexpr double far_off = 6.0;      // standard deviations of a reading that its repeats contradict
constexpr double others_agree = 0.5; // of how far it is off
constexpr double drop_share = 0.1;
constexpr double sensor_um = 2.0; // of a sensor, and
constexpr double sensor_share = 0.02;
constexpr double disagree_share = 0.1;
constexpr double disagree_um = 4.0;
constexpr double disagree_scatter = 5.0;
constexpr double least_um = 0.01; // a reading below it has no logarithm to speak of
constexpr std::size_t few_sensors = 3;

double logarithm(double um) {
    return std::log(std::max(um, least_um));
}

std::set<int> drops_of(const LevelReadings& level) {
    std::set<int> drops;
    for (const auto& [offset, readings] : level) {
        for (const LevelReading& r : readings) {
            drops.insert(r.drop);
        }
    }
    return drops;
}

std::vector<double> all_but(const std::vector<LevelReading>& readings, int drop) {
    std::vector<double> others;
    for (const LevelReading& r : readings) {
        if (r.drop != drop) {
            others.push_back(r.um);
        }
    }
    return others;
}

const LevelReading* of_drop(const std::vector<LevelReading>& readings, int drop) {
    const auto at =
        std::find_if(readings.begin(), readings.end(), [&](const LevelReading& r) { return r.drop == drop; });
    return at == readings.end() ? nullptr : &*at;
}

double spread(const std::vector<double>& values) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    return *high - *low;
}

// Between the ends of so many of these as lie closest to each other.
double spread_of_closest(std::vector<double> values, std::size_t count) {
    std::sort(values.begin(), values.end());
    double least = spread(values);
    for (std::size_t i = 0; i + count <= values.size(); ++i) {
        least = std::min(least, values[i + count - 1] - values[i]);
    }
    return least;
}

// More than half of so many, and two.
std::size_t majority(std::size_t all) {
    return std::max<std::size_t>(2, all / 2 + 1);
}

// How far a drop is from the others, and how far the majority of so many drops is apart: medians over the sensors, of
// logarithms.
struct DropAgainstOthers {
    double off = 0.0, others_apart = 0.0;
};
std::optional<DropAgainstOthers> against_others(const LevelReadings& level, int drop, std::size_t all,
                                                double resolution_um) {
    std::vector<double> off;
    std::vector<double> apart;
    for (const auto& [offset, readings] : level) {
        const LevelReading* own = of_drop(readings, drop);
        std::vector<double> others = all_but(readings, drop);
        if (own == nullptr || others.size() < 2) {
            continue;
        }
        const bool is_rounding = std::abs(own->um - median(others)) <= rounded_apart * resolution_um;
        std::transform(others.begin(), others.end(), others.begin(), logarithm);
        off.push_back(is_rounding ? 0.0 : logarithm(own->um) - median(others));
        apart.push_back(spread_of_closest(others, majority(all)));
    }
    return off.empty() ? std::nullopt : std::optional(DropAgainstOthers{median(off), median(apart)});
}

// The error that all sensors of a drop have in common (of logarithms), which is no error of one of them.
std::map<int, double> effects_of(const LevelReadings& level) {
    std::map<int, std::vector<double>> off;
    for (const auto& [offset, readings] : level) {
        if (readings.size() < 2) {
            continue;
        }
        std::vector<double> values;
        std::transform(readings.begin(), readings.end(), std::back_inserter(values),
                       [](const LevelReading& r) { return logarithm(r.um); });
        const double middle = median(values);
        for (const LevelReading& r : readings) {
            off[r.drop].push_back(logarithm(r.um) - middle);
        }
    }
    std::map<int, double> effects;
    for (const auto& [drop, values] : off) {
        effects[drop] = values.size() > few_sensors ? median(values) : 0.0;
    }
    return effects;
}

// The scatter of a sensor's readings here, apart from what their drops have in common: of the middle sensor. 0:
// too few to tell.
double scatter_here(const LevelReadings& level, const std::map<int, double>& effects) {
    std::vector<ScatterSample> samples;
    for (const auto& [offset, readings] : level) {
        if (readings.size() < 2) {
            continue;
        }
        const auto n = static_cast<double>(readings.size());
        const auto own = [&](const LevelReading& r) { return logarithm(r.um) - effects.at(r.drop); };
        double mean = 0.0;
        double squares = 0.0;
        for (const LevelReading& r : readings) {
            mean += own(r) / n;
        }
        for (const LevelReading& r : readings) {
            squares += std::pow(own(r) - mean, 2);
        }
        samples.push_back({std::sqrt(squares / (n - 1.0)), static_cast<int>(readings.size())});
    }
    return samples.size() > few_sensors ? middle_scatter(samples) : 0.0;
}

// How far the reading of a drop may be from the others', and how far it is.
struct ReadingAgainstOthers {
    double off_um = 0.0, limit_um = 0.0, others_apart_um = 0.0;
    double times() const { return std::abs(off_um) / limit_um; }
};
ReadingAgainstOthers against_others(const std::vector<LevelReading>& readings, const LevelReading& own, std::size_t all,
                                    const std::map<int, double>& effects, double scatter, double resolution_um) {
    std::vector<double> others; // as they would be in this drop
    for (const LevelReading& r : readings) {
        if (r.drop != own.drop) {
            others.push_back(r.um * std::exp(effects.at(own.drop) - effects.at(r.drop)));
        }
    }
    const double middle = median(others);
    return {.off_um = own.um - middle,
            .limit_um = std::max(sensor_um + sensor_share * std::abs(middle), far_off * scatter * std::abs(middle)) +
                        rounded_apart * resolution_um,
            .others_apart_um = spread_of_closest(others, majority(all))};
}

ContradictedReading take_out(std::vector<LevelReading>& readings, int drop) {
    ContradictedReading out{.drop = drop, .read_um = of_drop(readings, drop)->read_um};
    std::vector<double> others;
    for (const LevelReading& r : readings) {
        if (r.drop != drop) {
            others.push_back(r.read_um);
        }
    }
    out.repeats_um = median(others);
    std::erase_if(readings, [&](const LevelReading& r) { return r.drop == drop; });
    return out;
}

double mean_of(const std::vector<LevelReading>& readings) {
    double sum = 0.0;
    for (const LevelReading& r : readings) {
        sum += r.um;
    }
    return sum / static_cast<double>(readings.size());
}

// The readings of a sensor that fall into two halves, each of which agrees, far from each other: of these the half that
// does not lie between the neighbouring sensors where the other one does. None: the halves are not that far from each
// other, neither or both lie there.
std::vector<int> beside_neighbours(const LevelReadings& level, LevelReadings::const_iterator sensor,
                                   const std::map<int, double>& effects, double scatter, double resolution_um) {
    if (sensor->first < 0.0 || level.size() < 3) {
        return {};
    }
    constexpr double steepest = 8.0; // of neighbours
    double high = INFINITY;
    double low = 0.0;
    if (sensor->first > 0.0 && sensor != level.begin() && std::prev(sensor)->first >= 0.0) {
        high = mean_of(std::prev(sensor)->second);
        low = high / steepest;
    }
    if (const auto next = std::next(sensor); next != level.end()) {
        low = mean_of(next->second);
        high = std::min(high, steepest * low);
    }
    // As they would be without what their drops have in common.
    std::vector<std::pair<double, const LevelReading*>> order;
    for (const LevelReading& r : sensor->second) {
        order.emplace_back(r.um * std::exp(-effects.at(r.drop)), &r);
    }
    std::sort(order.begin(), order.end());
    const std::size_t half = order.size() / 2;
    struct Half {
        double low, high, mean = 0.0;
        std::vector<int> drops{};
    };
    const auto half_of = [&](std::size_t begin) {
        Half h{order[begin].first, order[begin + half - 1].first};
        for (std::size_t i = begin; i < begin + half; ++i) {
            h.mean += order[i].second->um / static_cast<double>(half);
            h.drops.push_back(order[i].second->drop);
        }
        return h;
    };
    const Half lower = half_of(0);
    const Half upper = half_of(half);
    const double off = upper.low - lower.high;
    const double limit =
        std::max(sensor_um + sensor_share * std::abs(lower.low), far_off * scatter * std::abs(lower.low)) +
        rounded_apart * resolution_um;
    if (!(off > limit) || std::max(lower.high - lower.low, upper.high - upper.low) >= others_agree * off) {
        return {};
    }
    const auto fits = [&](double um) {
        const double room = sensor_um + sensor_share * std::abs(um);
        return um >= low - room && um <= high + room;
    };
    return fits(lower.mean) == fits(upper.mean) ? std::vector<int>() : fits(lower.mean) ? upper.drops : lower.drops;
}

} // namespace

double RepeatScatter::at(double offset_mm) const {
    constexpr double least = 0.003;
    const auto known = of_sensor.find(offset_mm);
    return std::max(least, known == of_sensor.end() ? overall : known->second);
}

double middle_scatter(const std::vector<ScatterSample>& samples) {
    // Medians of chi2 over its degrees of freedom, from 1 on; then Wilson and Hilferty's (1931).
    constexpr std::array medians = {0.454936, 0.693147, 0.788658, 0.839173, 0.870292};
    std::vector<double> variances;
    for (const ScatterSample& s : samples) {
        const auto degrees = static_cast<std::size_t>(std::max(1, s.drops - 1));
        const double middle = degrees <= medians.size() ? medians[degrees - 1]
                                                        : std::pow(1.0 - 2.0 / (9.0 * static_cast<double>(degrees)), 3);
        variances.push_back(s.scatter * s.scatter / middle);
    }
    return std::sqrt(median(variances));
}

std::vector<ContradictedDrop> take_out_drops(LevelReadings& level, const RepeatScatter& scatter) {
    std::vector<ContradictedDrop> out;
    const std::size_t all = drops_of(level).size();
    const double limit = std::max(std::log1p(drop_share), far_off * scatter.at(0.0));
    while (all >= 3 && all - out.size() > 2 && 2 * (out.size() + 1) < all) {
        std::optional<ContradictedDrop> worst;
        double worst_off = limit;
        for (const int drop : drops_of(level)) {
            const auto there = against_others(level, drop, all, scatter.resolution_um);
            if (there && std::abs(there->off) > worst_off &&
                there->others_apart < others_agree * std::abs(there->off)) {
                worst_off = std::abs(there->off);
                worst = ContradictedDrop{drop, std::expm1(there->off)};
            }
        }
        if (!worst) {
            break;
        }
        for (auto& [offset, readings] : level) {
            std::erase_if(readings, [&](const LevelReading& r) { return r.drop == worst->drop; });
        }
        std::erase_if(level, [](const auto& sensor) { return sensor.second.empty(); });
        out.push_back(*worst);
    }
    return out;
}

std::vector<ContradictedReading> take_out_readings(LevelReadings& level, const RepeatScatter& scatter) {
    std::vector<ContradictedReading> out;
    const auto effects = effects_of(level);
    const double here = scatter_here(level, effects);
    for (auto sensor = level.begin(); sensor != level.end(); ++sensor) {
        auto& [offset, readings] = *sensor;
        const std::size_t all = readings.size();
        const double own = std::max(here, scatter.at(offset));
        while (all >= 3 && readings.size() > 2 && 2 * (all - readings.size() + 1) < all) {
            const LevelReading* worst = nullptr;
            double worst_times = 1.0;
            for (const LevelReading& r : readings) {
                const auto there = against_others(readings, r, all, effects, own, scatter.resolution_um);
                if (there.times() > worst_times && there.others_apart_um < others_agree * std::abs(there.off_um)) {
                    worst_times = there.times();
                    worst = &r;
                }
            }
            if (worst == nullptr) {
                break;
            }
            out.push_back(take_out(readings, worst->drop));
            out.back().offset_mm = offset;
        }
        if (all % 2 == 0 && readings.size() == all) {
            for (const int drop :
                 beside_neighbours(level, sensor, effects, std::sqrt(2.0) * own, scatter.resolution_um)) {
                out.push_back(take_out(readings, drop));
                out.back().offset_mm = offset;
            }
        }
    }
    return out;
}

LevelCompliance compliance_of(const LevelReadings& level, double pressure_kPa) {
    LevelCompliance compliance;
    for (const auto& [offset, readings] : level) {
        std::vector<double> um;
        std::transform(readings.begin(), readings.end(), std::back_inserter(um),
                       [](const LevelReading& r) { return r.um; });
        compliance[offset] = logarithm(median(um)) - std::log(pressure_kPa);
    }
    return compliance;
}

std::vector<ContradictedReading> take_out_by_levels(LevelReadings& level, double pressure_kPa,
                                                    const std::vector<LevelCompliance>& others,
                                                    const RepeatScatter& scatter) {
    std::vector<ContradictedReading> out;
    struct Witness {
        double middle = 0.0, apart = 0.0;
    };
    std::map<double, Witness> expected; // ln(deflection / pressure) at the other levels, by offset
    for (const auto& [offset, readings] : level) {
        std::vector<double> there;
        for (const LevelCompliance& other : others) {
            if (const auto at = other.find(offset); at != other.end()) {
                there.push_back(at->second);
            }
        }
        if (there.size() >= 2) {
            expected[offset] = {median(there), spread(there)};
        }
    }
    std::vector<double> off;
    for (const auto& [offset, own] : compliance_of(level, pressure_kPa)) {
        if (const auto at = expected.find(offset); at != expected.end()) {
            off.push_back(own - at->second.middle);
        }
    }
    if (off.size() <= few_sensors) {
        return out;
    }
    const double in_common = median(off);
    const auto disagreeing = disagreements(level, scatter);
    constexpr double third = 0.3; // of a logarithm
    for (auto& [offset, readings] : level) {
        const auto witness = expected.find(offset);
        const bool is_open =
            readings.size() == 1 || std::any_of(disagreeing.begin(), disagreeing.end(),
                                                [&, at = offset](const Disagreement& d) { return d.offset_mm == at; });
        if (witness == expected.end() || !is_open) {
            continue;
        }
        const double likely = witness->second.middle + in_common + std::log(pressure_kPa);
        const std::vector<LevelReading> all = readings;
        for (const LevelReading& r : all) {
            const double apart = std::abs(logarithm(r.um) - likely);
            if (apart > third && witness->second.apart < others_agree * apart &&
                apart * std::exp(likely) > sensor_um + rounded_apart * scatter.resolution_um) {
                out.push_back({.drop = r.drop,
                               .offset_mm = offset,
                               .read_um = r.read_um,
                               .repeats_um = std::exp(likely) * r.read_um / r.um,
                               .by_levels = true});
                std::erase_if(readings, [&](const LevelReading& other) { return other.drop == r.drop; });
            }
        }
    }
    std::erase_if(level, [](const auto& sensor) { return sensor.second.empty(); });
    return out;
}

std::vector<Disagreement> disagreements(const LevelReadings& level, const RepeatScatter& scatter) {
    std::vector<Disagreement> found;
    for (const auto& [offset, readings] : level) {
        if (readings.size() < 2) {
            continue;
        }
        std::vector<double> values;
        std::transform(readings.begin(), readings.end(), std::back_inserter(values),
                       [](const LevelReading& r) { return r.um; });
        const double mean = mean_of(readings);
        const double apart = spread(values);
        const double share = std::max(disagree_share, disagree_scatter * scatter.at(offset));
        if (apart > std::max(disagree_um, share * std::abs(mean)) + rounded_apart * scatter.resolution_um &&
            mean > 0.0) {
            const auto [low, high] = std::minmax_element(values.begin(), values.end());
            found.push_back({.offset_mm = offset, .share = apart / mean, .low_um = *low, .high_um = *high});
        }
    }
    return found;
}

} // namespace explore::data
