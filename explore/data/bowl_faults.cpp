#include "data/bowl_faults.h"

#include "data/bowl_shape.h"
#include "data/median.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <optional>

namespace explore::data {

namespace {

// Of powers of ten, and mils for micrometres or millimetres.
constexpr std::array unit_factors{10.0, 25.4, 1000.0, 25400.0, 100.0, 1000.0 / 25.4};

// The reading over what the sensors beside it say: between them, or by the next two of an end.
struct Excess {
    double log = 0.0;       // -infinity: of no positive reading
    double deviation = 0.0; // by those it is compared with
};

// Of number i of a bowl; none: the others do not say.
std::optional<Excess> excess_at(const Bowl& bowl, std::size_t i) {
    const std::size_t n = bowl.size();
    if (n < 3) {
        return std::nullopt;
    }
    const BowlPoint& a = bowl[i == 0 ? 1 : i - 1];
    const BowlPoint& b = bowl[i == 0 ? 2 : i == n - 1 ? n - 3 : i + 1];
    const double apart = stretched(b) - stretched(a);
    if (!(a.value > 0.0) || !(b.value > 0.0) || std::abs(apart) < 1e-6) {
        return std::nullopt;
    }
    const double t = (stretched(bowl[i]) - stretched(a)) / apart;
    const double expected = (1.0 - t) * std::log(a.value) + t * std::log(b.value);
    return Excess{bowl[i].value > 0.0 ? std::log(bowl[i].value) - expected : -INFINITY,
                  std::hypot((1.0 - t) * a.deviation / a.value, t * b.deviation / b.value)};
}

// Of the logarithm. Bowls are steeper near the load and flatter far from it than the next two say.
constexpr double near_expected = 0.75;

struct Mended {
    BowlFault fault;
    std::vector<Bowl> bowls;
};

// Two sensors exchanged in every bowl that has both. only: of this one alone.
Mended exchanged(std::vector<Bowl> bowls, double a, double b, std::optional<std::size_t> only) {
    BowlFault fault{.kind = BowlFault::Kind::exchanged, .rows = {}, .offsets = {a, b}, .of_one_load = only.has_value()};
    for (std::size_t i = 0; i < bowls.size(); ++i) {
        Bowl& bowl = bowls[i];
        BowlPoint* one = only && *only != i ? nullptr : at(bowl, a);
        BowlPoint* other = only && *only != i ? nullptr : at(bowl, b);
        if (one != nullptr && other != nullptr) {
            fault.rows.insert(fault.rows.end(), {one->row, other->row});
            std::swap(one->value, other->value);
            std::swap(one->deviation, other->deviation);
            std::swap(one->row, other->row);
        }
    }
    return {std::move(fault), std::move(bowls)};
}

Mended reversed(std::vector<Bowl> bowls) {
    BowlFault fault{.kind = BowlFault::Kind::reversed, .rows = {}, .offsets = {}};
    for (Bowl& bowl : bowls) {
        const Bowl before = bowl;
        for (std::size_t i = 0; i < bowl.size(); ++i) {
            fault.rows.push_back(before[i].row);
            bowl[i] = before[before.size() - 1 - i];
            bowl[i].offset = before[i].offset;
        }
    }
    return {std::move(fault), std::move(bowls)};
}

// only: the load whose reading it is; none: of the sensor, under every load.
Mended rescaled(std::vector<Bowl> bowls, double offset, double factor, std::optional<std::size_t> only) {
    BowlFault fault{.kind = BowlFault::Kind::factor, .rows = {}, .offsets = {offset}, .factor = factor};
    for (std::size_t b = 0; b < bowls.size(); ++b) {
        BowlPoint* reading = only && *only != b ? nullptr : at(bowls[b], offset);
        if (reading != nullptr) {
            fault.rows.push_back(reading->row);
            reading->value /= factor;
            reading->deviation /= factor;
        }
    }
    return {std::move(fault), std::move(bowls)};
}

// Whether what is mended reads about what its neighbours say, where these say it well enough, and about the same share
// of what it reads under another load as its neighbours do.
bool is_as_expected(const Mended& mended) {
    constexpr double vague = 0.3; // deviation of the logarithm
    constexpr double share = 0.5; // of the logarithm
    const auto is_mended = [&](const BowlPoint& r) {
        return std::find(mended.fault.rows.begin(), mended.fault.rows.end(), r.row) != mended.fault.rows.end();
    };
    double variance = 0.0;
    double count = 0.0;
    for (const Bowl& bowl : mended.bowls) {
        for (std::size_t i = 0; i < bowl.size(); ++i) {
            const auto own = is_mended(bowl[i]) ? excess_at(bowl, i) : std::nullopt;
            if (!own) {
                continue;
            }
            if (std::abs(own->log) > near_expected) {
                return false;
            }
            variance += own->deviation * own->deviation;
            count += 1.0;
            for (const Bowl& other : mended.bowls) {
                const BowlPoint* there = at(other, bowl[i].offset);
                if (there == nullptr || is_mended(*there) || !(there->value > 0.0)) {
                    continue;
                }
                const auto theirs = excess_at(other, static_cast<std::size_t>(there - other.data()));
                if (theirs && std::abs(own->log - theirs->log) > share) {
                    return false;
                }
            }
        }
    }
    return count == 0.0 || std::sqrt(variance) / count < vague;
}

// The least roughness that is left without one of the sensors: what a wrong reading would leave.
double roughness_without_one(const std::vector<Bowl>& bowls) {
    double least = INFINITY;
    for (const double offset : offsets_of(bowls)) {
        std::vector<Bowl> others = bowls;
        for (Bowl& bowl : others) {
            if (const BowlPoint* own = at(bowl, offset)) {
                bowl.erase(bowl.begin() + (own - bowl.data()));
            }
        }
        if (all_fall(others)) {
            least = std::min(least, roughness(others));
        }
    }
    return least;
}

// Of those that make every bowl fall the one after which they are smoothest, if by far.
std::optional<Mended> mended(const std::vector<Bowl>& bowls) {
    const std::vector<double> offsets = offsets_of(bowls);
    std::vector<Mended> options;
    const auto offer = [&](Mended option) {
        if (all_fall(option.bowls) && (option.fault.kind != BowlFault::Kind::factor || is_as_expected(option))) {
            options.push_back(std::move(option));
        }
    };
    offer(reversed(bowls));
    for (std::size_t i = 0; i < offsets.size(); ++i) {
        for (std::size_t j = i + 1; j < offsets.size(); ++j) {
            offer(exchanged(bowls, offsets[i], offsets[j], std::nullopt));
            for (std::size_t b = 0; bowls.size() > 1 && b < bowls.size(); ++b) {
                offer(exchanged(bowls, offsets[i], offsets[j], b));
            }
        }
        for (const double factor : unit_factors) {
            for (const double own : {factor, 1.0 / factor}) {
                offer(rescaled(bowls, offsets[i], own, std::nullopt));
                for (std::size_t b = 0; bowls.size() > 1 && b < bowls.size(); ++b) {
                    offer(rescaled(bowls, offsets[i], own, b));
                }
            }
        }
    }
    if (options.empty()) {
        return std::nullopt;
    }
    // A whole line that falls from its far end can be nothing else.
    constexpr std::size_t line = 4; // sensors
    if (options[0].fault.kind == BowlFault::Kind::reversed && offsets.size() >= line) {
        return options[0];
    }
    const auto smoothest = std::min_element(options.begin(), options.end(), [](const Mended& a, const Mended& b) {
        return roughness(a.bowls) < roughness(b.bowls);
    });
    // In order it is smoother by far than it was, and not rougher than without a sensor that would be merely wrong.
    constexpr double smoother = 0.5;
    constexpr double rougher = 2.0;
    const double left = roughness(smoothest->bowls);
    if (left > smoother * roughness(bowls) || left > rougher * roughness_without_one(bowls)) {
        return std::nullopt;
    }
    return *smoothest;
}

// A sensor in another unit at an end of the line need not make the bowl rise: the next two say what it should read.
std::optional<Mended> factor_at_end(const std::vector<Bowl>& bowls) {
    const std::vector<double> offsets = offsets_of(bowls);
    constexpr std::size_t least = 4; // sensors
    if (offsets.size() < least) {
        return std::nullopt;
    }
    for (const bool is_first : {true, false}) {
        const double own = is_first ? offsets.front() : offsets.back();
        std::vector<double> excess; // of the logarithm
        for (Bowl bowl : bowls) {
            const std::size_t n = bowl.size();
            BowlPoint* reading = at(bowl, own);
            constexpr double clear = 8.0; // standard deviations
            const auto found = excess_at(bowl, is_first ? 0 : n - 1);
            if (n < least || reading == nullptr || !(reading->value > clear * reading->deviation) || !found) {
                return std::nullopt;
            }
            excess.push_back(found->log);
        }
        std::optional<Mended> best;
        double nearest = near_expected;
        for (const double factor : unit_factors) {
            for (const double size : {factor, 1.0 / factor}) {
                std::optional<std::size_t> only; // the load of which it is
                std::size_t count = 0;
                double away = 0.0;
                bool are_plain = true; // the others
                for (std::size_t b = 0; b < excess.size(); ++b) {
                    const double distance = std::abs(excess[b] - std::log(size));
                    if (distance < near_expected) {
                        ++count;
                        only = b;
                        away = std::max(away, distance);
                    } else {
                        are_plain = are_plain && std::abs(excess[b]) < near_expected;
                    }
                }
                const bool is_whole = count == excess.size();
                if (count == 0 || !are_plain || (!is_whole && count > 1) || away >= nearest ||
                    (size < 1.0 && factor < 20.0)) {
                    continue;
                }
                Mended option = rescaled(bowls, own, size, is_whole ? std::nullopt : only);
                if (all_fall(option.bowls) && is_as_expected(option)) {
                    nearest = away;
                    best = std::move(option);
                }
            }
        }
        if (best) {
            return best;
        }
    }
    return std::nullopt;
}

// All readings of one load in another unit: over the load's strength all sensors read as many times more or less than
// under the others. Of two loads the one whose half-space is the less likely is wrong.
std::optional<BowlFault> load_in_another_unit(const std::vector<Bowl>& bowls) {
    constexpr std::size_t least = 4; // sensors
    constexpr double near = 0.6;     // of the logarithm: what the stress makes of a pavement
    constexpr double alike = 0.5;    // between sensors
    constexpr double usual_Pa = 200e6;
    const auto compliance = [](const BowlPoint& r) { return std::log(r.value / r.strength); };
    std::optional<BowlFault> found;
    double farthest = 0.0;
    for (std::size_t b = 0; bowls.size() > 1 && b < bowls.size(); ++b) {
        std::vector<double> apart;
        for (const BowlPoint& own : bowls[b]) {
            std::vector<double> others;
            for (std::size_t o = 0; o < bowls.size(); ++o) {
                const BowlPoint* there = o == b ? nullptr : at(bowls[o], own.offset);
                if (there != nullptr && there->value > 0.0 && there->strength > 0.0) {
                    others.push_back(compliance(*there));
                }
            }
            std::sort(others.begin(), others.end());
            const std::size_t n = others.size();
            // Where the two in the middle disagree, one of them is the wrong one.
            const bool agree = n > 0 && others[n / 2] - others[(n - 1) / 2] < near;
            if (agree && own.value > 0.0 && own.strength > 0.0) {
                apart.push_back(compliance(own) - median(others));
            }
        }
        if (apart.size() < least) {
            continue;
        }
        const double middle = median(apart);
        const auto [lowest, highest] = std::ranges::minmax(apart);
        const double unlikely = std::abs(compliance(bowls[b][0]) - std::log(2.0 / usual_Pa));
        double nearest = highest - lowest < alike && unlikely > farthest ? near : 0.0;
        for (const double factor : unit_factors) {
            for (const double size : {factor, 1.0 / factor}) {
                if (const double away = std::abs(middle - std::log(size)); away < nearest) {
                    nearest = away;
                    farthest = unlikely;
                    found = BowlFault{.kind = BowlFault::Kind::factor,
                                      .rows = {},
                                      .offsets = {},
                                      .factor = size,
                                      .of_one_load = true};
                    for (const BowlPoint& reading : bowls[b]) {
                        found->rows.push_back(reading.row);
                    }
                }
            }
        }
    }
    return found;
}

bool are_alike(const std::vector<double>& values) {
    constexpr double same = 1e-9;
    return std::all_of(values.begin(), values.end(),
                       [&](double v) { return std::abs(v - values[0]) <= same * std::abs(values[0]); });
}

void add_constants(const std::vector<Bowl>& bowls, std::vector<BowlFault>& faults) {
    constexpr std::size_t least = 4;
    for (const Bowl& bowl : bowls) {
        BowlFault fault{.kind = BowlFault::Kind::constant, .rows = {}, .offsets = {}};
        std::vector<double> values;
        for (const BowlPoint& reading : bowl) {
            values.push_back(reading.value);
            fault.rows.push_back(reading.row);
        }
        if (values.size() >= least && are_alike(values)) {
            faults.push_back(std::move(fault));
        }
    }
    // A sensor under loads whose other sensors differ.
    for (const double offset : offsets_of(bowls)) {
        BowlFault fault{.kind = BowlFault::Kind::constant, .rows = {}, .offsets = {offset}};
        std::vector<double> own;
        std::vector<double> others;
        for (Bowl bowl : bowls) {
            const BowlPoint* reading = at(bowl, offset);
            double sum = 0.0;
            for (const BowlPoint& other : bowl) {
                sum += &other == reading ? 0.0 : other.value;
            }
            if (reading != nullptr && bowl.size() >= least) {
                own.push_back(reading->value);
                others.push_back(sum);
                fault.rows.push_back(reading->row);
            }
        }
        constexpr double differ = 1.15;
        const auto [low, high] = std::minmax_element(others.begin(), others.end());
        if (own.size() > 1 && own[0] != 0.0 && are_alike(own) && *high > differ * *low) {
            faults.push_back(std::move(fault));
        }
    }
}

std::string mm(double offset) {
    return fmt::format("{:g}", std::round(1e4 * offset) / 10.0);
}

} // namespace

std::string BowlFault::words() const {
    switch (kind) {
    case Kind::exchanged:
        if (is_by_model()) {
            return fmt::format("{} and {} are exchanged", places[0], places[1]);
        }
        return fmt::format("the {} at {} and {} mm are exchanged{}", of_one_load ? "readings" : "sensors",
                           mm(offsets[0]), mm(offsets[1]), of_one_load ? " under one load" : "");
    case Kind::reversed: return "the sensors are counted from the far end: the bowl rises with distance";
    case Kind::factor: {
        const bool is_large = factor > 1.0;
        if (of_one_load) {
            return fmt::format("all readings of one load are {:g} times too {} (another unit?)",
                               is_large ? factor : 1.0 / factor, is_large ? "large" : "small");
        }
        return fmt::format("{} at {} mm {} {:g} times too {} (another unit?)",
                           rows.size() > 1 ? "the sensor" : "a reading", mm(offsets[0]),
                           rows.size() > 1 ? "reads" : "is", is_large ? factor : 1.0 / factor,
                           is_large ? "large" : "small");
    }
    case Kind::constant:
        return offsets.empty() ? "all sensors read one value under a load"
                               : fmt::format("the sensor at {} mm reads one value under every load", mm(offsets[0]));
    case Kind::rises:
        return fmt::format("the bowl rises from {} to {} mm: no pavement does that", mm(offsets[0]), mm(offsets[1]));
    }
    return "";
}

std::vector<BowlFault> bowl_faults(const std::vector<BowlPoint>& readings) {
    const std::vector<Bowl> bowls = bowls_of(readings);
    std::vector<BowlFault> faults;
    add_constants(bowls, faults);
    if (!faults.empty()) {
        return faults;
    }
    if (auto found = load_in_another_unit(bowls)) {
        faults.push_back(std::move(*found));
        return faults;
    }
    if (all_fall(bowls)) {
        if (auto found = factor_at_end(bowls)) {
            faults.push_back(std::move(found->fault));
        }
        return faults;
    }
    if (auto found = mended(bowls)) {
        faults.push_back(std::move(found->fault));
        return faults;
    }
    for (const Bowl& bowl : bowls) {
        if (const auto rise = first_rise(bowl)) {
            const auto [i, j] = *rise;
            faults.push_back({.kind = BowlFault::Kind::rises,
                              .rows = {bowl[i].row, bowl[j].row},
                              .offsets = {bowl[i].offset, bowl[j].offset}});
        }
    }
    const std::vector<double> offsets = offsets_of(bowls);
    for (std::size_t i = 0; faults.empty() && i + 1 < offsets.size(); ++i) {
        if (rise_together(bowls, offsets[i], offsets[i + 1])) {
            BowlFault fault{.kind = BowlFault::Kind::rises, .rows = {}, .offsets = {offsets[i], offsets[i + 1]}};
            for (const Bowl& bowl : bowls) {
                for (const double offset : fault.offsets) {
                    if (const BowlPoint* reading = at(bowl, offset)) {
                        fault.rows.push_back(reading->row);
                    }
                }
            }
            faults.push_back(std::move(fault));
        }
    }
    return faults;
}

} // namespace explore::data
