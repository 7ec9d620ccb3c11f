// The deflection bowls of an FWD station, made of its drops, and what is read off them.
//
// Drops. Left out are those that the file flags, those that cannot be (plausibility.h) and a seating drop: the first
// one, when it stands alone at its pressure and the others repeat one (or, of two drops, when it does so at most
// stations of the road), or when its deflection differs by more than 5 % and four times what drops of the road scatter
// by from repeats that agree within 2.5 %. The others make levels: a level holds the drops whose pressure is within 10
// % of its highest. The level that counts is the highest, or the one nearest to the target load. Drops of a level are
// scaled in proportion to their median pressure, and every sensor's deflection is the mean over them, without the drops
// and the readings that their repeats contradict (drop_agreement.h). A mean of n drops has their covariance over n,
// what all sensors of a drop have in common included; a median of each sensor by itself would have up to 1.57 times the
// variance, and be of another drop at every sensor.
//
// Readings. Sensors are good to 2 um + 2 % each (what manufacturers state). A reading below 1 um is of a dead sensor
// and left out. Two others contradict each other where the outer one is more than a quarter larger: the reading that
// contradicts the most others is left out, as long as one contradicts two or more, or stands at less than a quarter of
// the outer one (of a single pair the inner one). Deflections fall outwards; a rise within what both
// sensors are good to stays, with a remark; beyond that the last sensor is left out, and anywhere else the station:
// which of the two is wrong cannot be told. Sensors behind the plate count only where there is no reading ahead of it
// at that distance; the two sides are compared.
//
// Deflection ratio: D250/D0, the deflection 250 mm from the centre of the load over the one at the centre. The
// definition, and its reading (below 0.6 points to a weak pavement, 0.6 to 0.7 to a sound unbound one, above 0.8 to a
// bound one), are those commonly cited from Austroads (Guide to Pavement Technology Part 5, pavement evaluation and
// treatment design); the guide itself was not at hand. The limit of 0.6 is also that of figure 1 of Kathirgamanathan
// and Vignarajah. A station passes at 0.6 or more. The ratio hardly depends on the pressure, which scales both
// deflections.
//
// Between sensors a deflection is interpolated linearly in ln(deflection): outside the plate a bowl falls off about
// exponentially, and two positive, falling readings give a value between them. The inner one must be outside the plate,
// where the bowl is no longer flat. Between 200 and 300 mm the forward model's own bowls on grids/captif-p1-fwd.toml
// (k1 1200 to 9000, subgrade 30 to 100 MPa) are met within 1 %.
#pragma once

#include "base/outcome.h"
#include "data/drop_agreement.h"
#include "data/fwd.h"
#include "data/median.h"

namespace explore::data {

inline constexpr double ratio_offset_mm = 250.0;
inline constexpr double deflection_ratio_limit = 0.6;

struct BowlReading {
    double offset_mm = 0.0;
    double deflection_um = 0.0;      // mean of the drops, at the pressure of the bowl
    int drops = 1;                   // that it is the mean of
    std::optional<double> scatter{}; // standard deviation of ln(deflection / pressure) over them; nothing: one drop
    bool disagrees = false;          // they differ by more than drops do, and nothing tells which is right
    double resolution_um = 0.0;      // of the file; 0: not seen
};

struct DeflectionBowl {
    double radius_mm = 0.0;
    double pressure_kPa = 0.0;         // that the deflections belong to
    std::vector<int> drops;            // numbers of the drops it is made of
    std::vector<BowlReading> readings; // by offset; the first is at 0, all are positive and fall (but for the accuracy)

    double d0_um() const { return readings[0].deflection_um; }
    // Deflection at a distance: a reading, or between two outside the plate; nothing: no sensors from which to tell.
    std::optional<double> at(double offset_mm) const;
    bool has_sensor_at(double offset_mm) const;
    std::optional<double> deflection_ratio() const;
    double force_kN() const;
};

// Which drops to use.
struct DropChoice {
    std::vector<int> numbers{};                  // these and no others; empty: chosen as above
    std::optional<double> target_pressure_kPa{}; // the level nearest to it, within 15 %
    std::optional<double> target_force_kN{};     // the same as a force on the plate
    std::optional<RepeatScatter> scatter{};      // of the road; nothing: what sensors repeat within
    double resolution_um = 0.0;                  // of the station's file; 0: not known
    bool keeps_contradicted = false;             // drops and readings that their repeats contradict
    bool first_of_two_seats = false; // also the first of two drops of different pressure seats the plate, as elsewhere
};

enum class LeftOut { flagged, implausible, seating, contradicted, another_level, not_chosen };
struct DropLeftOut {
    int number = 0;
    LeftOut why = LeftOut::another_level;
    std::string words; // for flagged, implausible and contradicted: by what
};

struct StationBowls {
    std::vector<DeflectionBowl> levels; // by rising pressure
    std::size_t main = 0;               // the level that counts
    std::vector<DropLeftOut> left_out;
    std::vector<ContradictedReading> readings_left_out; // that their repeats contradict
    std::vector<Disagreement> disagreements;            // of sensors whose drops nothing tells the right ones of
    std::vector<std::string> remarks;                   // on the readings
    std::string doubt;                                  // doubtful(), of the level that counts

    const DeflectionBowl& bowl() const { return levels[main]; }
};

// The bowls, or why the readings cannot be right.
pave::Outcome<StationBowls> bowls_of(const FwdStation& station, const DropChoice& choice = {});

// Root mean square scatter of a reading over repeated drops (its standard deviation as a share), over all levels and
// sensors whose drops do not contradict each other, without what rounding makes of it; nothing: no drop is repeated.
std::optional<double> repeatability(const std::vector<const DeflectionBowl*>& bowls);

} // namespace explore::data
