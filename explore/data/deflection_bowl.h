// The deflection bowl of an FWD station, made of its drops, and what is read off it.
//
// Drops: those whose pressure is within 10 % of the station's highest count (the others, such as a seating drop, see a
// stress-dependent pavement in another state). Each is scaled in proportion to the median pressure of those, and every
// sensor's deflection is the median over them.
//
// Deflection ratio: D250/D0, the deflection 250 mm from the centre of the load over the one at the centre. The
// definition, and its reading (below 0.6 points to a weak pavement, 0.6 to 0.7 to a sound unbound one, above 0.8 to a
// bound one), are those commonly cited from Austroads (Guide to Pavement Technology Part 5, pavement evaluation and
// treatment design); the guide itself was not at hand. The limit of 0.6 is also that of figure 1 of Kathirgamanathan
// and Vignarajah. A station passes at 0.6 or more. The ratio hardly depends on the pressure, which scales both
// deflections.
//
// Without a sensor at 250 mm, its deflection is interpolated linearly in ln(deflection) between the two nearest
// sensors: outside the plate a bowl falls off about exponentially, and two positive, falling readings give a value
// between them. The inner one must be outside the plate, where the bowl is no longer flat. Between 200 and 300 mm the
// forward model's own bowls on grids/captif-p1-fwd.toml (k1 1200 to 9000, subgrade 30 to 100 MPa) are met within 1 %.
#pragma once

#include "base/outcome.h"
#include "data/fwd.h"

namespace explore::data {

inline constexpr double ratio_offset_mm = 250.0;
inline constexpr double deflection_ratio_limit = 0.6;

struct DeflectionBowl {
    double radius_mm = 0.0;
    double pressure_kPa = 0.0;        // that the deflections belong to
    std::vector<int> drops;           // numbers of the drops it is made of
    std::vector<FwdReading> readings; // by offset; the first is at 0, all are positive and fall (but for 2 um)
    std::optional<double> d250_um;    // nothing: no sensors from which to tell
    bool d250_is_interpolated = false;

    double d0_um() const { return readings[0].deflection_um; }
    std::optional<double> deflection_ratio() const {
        return d250_um ? std::optional(*d250_um / d0_um()) : std::nullopt;
    }
};

// The bowl, or why the readings cannot be right.
pave::Outcome<DeflectionBowl> bowl_of(const FwdStation& station);

// The middle value; of an even number the mean of the two in the middle. Not of none.
double median(std::vector<double> values);

} // namespace explore::data
