// Repeated drops of an FWD: how the readings of one place under one load differ from drop to drop.
#pragma once

#include "data/fwd.h"

#include <Eigen/Dense>

namespace explore::data {

// Drops of one level at one station (deflection_bowl.h): the sensors that read in all of them.
struct RepeatedDrops {
    std::vector<double> offsets_mm;
    std::vector<double> deflections_um; // at the pressure of the bowl
    int drops = 2;                      // at least
    Eigen::MatrixXd scatter; // sums over the drops of e_i e_j, e = ln(deflection / pressure) less its mean over them
};

// In the order of the stations. Left out are the drops and the sensors that deflection_bowl.h leaves out, and whole
// every drop with a reading that its repeats contradict. left_out: those that are contradicted are added, in words.
std::vector<RepeatedDrops> repeated_drops(const std::vector<FwdStation>& stations, std::vector<std::string>& left_out);

} // namespace explore::data
