// The answer from what was found of a road: the same ledger and the same decision as of one station.
#pragma once

#include "analysis/road/road.h"

namespace explore::analysis {

// How often the best possible decision between two effects is right, by these readings.
struct RoadConfounding {
    std::size_t a = 0, b = 0; // RoadEffect::candidate
    double rate = 1.0;
};

// The marginal likelihood of an effect whose size, in unit coordinates, is `size` with this standard deviation, where
// the fit leaves chi2 with the road's degrees of freedom, those of the size among them.
double road_evidence(hypotheses::Kind kind, double chi2, double dof, const problem::Axis& axis, double typical,
                     double size, double deviation);

// A sensor whose readings are multiplied by a factor: `share` is its logarithm, with its standard deviation; chi2 and p
// are set.
inline constexpr std::string_view sensor_gain = "sensor-gain";
void set_gain(RoadEffect& effect, double offset_mm, double share, double deviation, double dof);

// Sets what follows: the decision, the verdict, the causes, and the order of the effects, what is most probable first.
// Effects that were not fitted keep their place after those that were.
void decide_on_road(RoadDiagnosis& diagnosis, const std::vector<RoadConfounding>& confounding);

} // namespace explore::analysis
