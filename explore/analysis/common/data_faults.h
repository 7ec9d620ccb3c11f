// Faults of the readings of a study, found without a model: check, fit and diagnose say them, diagnose goes
// on with what it can mend.
#pragma once

#include "data/bowl_faults.h"
#include "study/study.h"

namespace explore::analysis {

// Of the deflections under single circles; readings in time by the largest of each sensor.
std::vector<data::BowlFault> data_faults(const study::Study& study);

// The study with its readings as they were meant, where a fault says how: at their places, in their unit.
study::Study mended(study::Study study, const std::vector<data::BowlFault>& faults);

// Readings in steps whose rounding their stated noise does not hold.
struct Rounding {
    pave::pavement::Quantity quantity{};
    double step = 0.0; // SI
    std::string words() const;
};
std::vector<Rounding> roundings(const study::Study& study);
// The study with the variance of these steps, step^2 / 12, added to that of the readings.
study::Study with_rounding(study::Study study, const std::vector<Rounding>& roundings);

// One sentence a fault.
std::vector<std::string> fault_words(const std::vector<data::BowlFault>& faults);

} // namespace explore::analysis
