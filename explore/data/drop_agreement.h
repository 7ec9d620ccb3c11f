// Whether the drops of a level agree, and which drop or single reading the others contradict.
//
// Compared is ln(deflection / pressure). With three drops or more:
//   a drop   whose deflections differ from those of the others by more than 10 % (median over the sensors) and six
//   times
//            what drops of this road scatter by, where the others agree within half of that;
//   a reading that differs from the others of its sensor by more than the sensor is good to (2 um + 2 %) and six times
//            what this sensor scatters by along the road, or what the sensors scatter by here, once what all sensors of
//            its drop have in common is taken off, where the others agree within half of that.
// Those are left out as long as more than half of the drops, and two, are left: it is these that have to agree. Of two
// drops, or two halves that agree each, neither has a majority: readings are left out where they differ as much and
// only the other ones lie between the neighbouring sensors'.
#pragma once

#include "data/fwd.h"

#include <map>
#include <optional>
#include <vector>

namespace explore::data {

// Deflections within as many steps of the file of each other may only be rounded apart.
inline constexpr double rounded_apart = 1.5;

// Standard deviation of ln(deflection / pressure) over repeated drops: of the middle one of a road's groups of drops,
// so that single readings do not rule it.
struct RepeatScatter {
    std::map<double, double> of_sensor{}; // by offset, where enough groups tell
    double overall = 0.02;                // what sensors repeat within, unless the road tells better
    double resolution_um = 0.0;           // steps of the file

    double at(double offset_mm) const;
};

// Of samples (standard deviation, number of drops).
struct ScatterSample {
    double scatter = 0.0;
    int drops = 2;
};
// The standard deviation behind them by their median. Not of none.
double middle_scatter(const std::vector<ScatterSample>& samples);

// The readings of a level, at one pressure.
struct LevelReading {
    int drop = 0;
    double um = 0.0;      // at the pressure of the level
    double read_um = 0.0; // as it was read
};
using LevelReadings = std::map<double, std::vector<LevelReading>>; // by offset

// One that the others contradict.
struct ContradictedReading {
    int drop = 0;
    double offset_mm = 0.0;
    double read_um = 0.0, repeats_um = 0.0; // the latter: median, or what other levels of load make of it
    bool by_levels = false;
};
struct ContradictedDrop {
    int drop = 0;
    double share = 0.0; // its deflections over those of the others - 1
};

// A sensor whose drops disagree and nothing tells which is right.
struct Disagreement {
    double offset_mm = 0.0;
    double share = 0.0; // of the mean, between the lowest and the highest
    double low_um = 0.0, high_um = 0.0;
};

// Takes the drops out that the others contradict.
std::vector<ContradictedDrop> take_out_drops(LevelReadings& level, const RepeatScatter& scatter);
// Takes single readings out.
std::vector<ContradictedReading> take_out_readings(LevelReadings& level, const RepeatScatter& scatter);
// ln(deflection / pressure) of a sensor, by offset, of the middle drop of a level.
using LevelCompliance = std::map<double, double>;
// Takes the readings of sensors out of which no two drops are left that agree, where two other levels or more agree
// within half of what a reading is off from them (what all sensors of the level have in common taken off), and that is
// more than a third: no pavement bends that much otherwise at one sensor than at the next.
std::vector<ContradictedReading> take_out_by_levels(LevelReadings& level, double pressure_kPa,
                                                    const std::vector<LevelCompliance>& others,
                                                    const RepeatScatter& scatter);
LevelCompliance compliance_of(const LevelReadings& level, double pressure_kPa);
// The remaining differences of more than 10 %, 4 um and five times the scatter, by offset.
std::vector<Disagreement> disagreements(const LevelReadings& level, const RepeatScatter& scatter);

} // namespace explore::data
