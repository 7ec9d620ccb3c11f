#include "hypotheses/hypothesis.h"

#include <algorithm>
#include <cmath>

namespace explore::hypotheses {

namespace {

constexpr double as_stated = 0.25; // and as much for noise of another size
constexpr double one_effect = 0.25;
constexpr double two_effects = 0.05;
constexpr double bad_readings = 0.1;
constexpr double corrections = 0.05;
constexpr double layouts = 0.05;
constexpr double tails = 0.05;  // as often as one wrong reading
constexpr double common = 0.04; // errors that the readings of a load share, of the usual size of them
constexpr double alike = 0.05;  // of what an effect has: of neighbouring readings

double share(std::size_t count) {
    return 1.0 / static_cast<double>(std::max<std::size_t>(1, count));
}

} // namespace

double log_prior(Kind kind, const Counts& counts, std::size_t variants, std::size_t bad) {
    switch (kind) {
    case Kind::none:
    case Kind::noise: return std::log(as_stated);
    case Kind::effect: return std::log(one_effect * share(counts.effects) * share(variants));
    case Kind::effects:
        return std::log(two_effects * share(counts.effects * std::max<std::size_t>(1, counts.effects - 1) / 2) *
                        share(variants));
    case Kind::readings: { // half as often one more; which of them: any
        double probability = bad_readings;
        for (std::size_t i = 0; i < bad; ++i) {
            const double left = static_cast<double>(counts.readings) - static_cast<double>(i);
            probability *= 0.5 * static_cast<double>(i + 1) / std::max(1.0, left);
        }
        return std::log(probability);
    }
    case Kind::correction: return std::log(corrections * share(counts.channels));
    case Kind::layout: return std::log(layouts * share(variants));
    }
    return -INFINITY;
}

double log_prior_of_structure(std::string_view key, const Counts& counts) {
    return std::log(key == "heavy-tailed" ? tails
                    : key == "common"     ? common
                                          : alike * one_effect * share(counts.effects));
}

} // namespace explore::hypotheses
