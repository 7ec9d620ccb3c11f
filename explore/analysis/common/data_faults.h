// Faults in the readings of a study, found without a model: check, fit and diagnose report them, and diagnose goes on
// with those mended that it can mend.
#pragma once

#include "data/bowl_faults.h"
#include "study/study.h"

#include <optional>

namespace explore::analysis {

// Faults of deflections under single circles; of a history the largest value of each sensor is checked.
std::vector<data::BowlFault> data_faults(const study::Study& study);

// The study with its readings corrected where a fault shows how: at their true places, in their true unit.
study::Study mended(study::Study study, const std::vector<data::BowlFault>& faults);

// Readings in steps so large that the stated noise does not cover the rounding.
struct Rounding {
    pave::pavement::Quantity quantity{};
    double step = 0.0; // SI
    std::string words() const;
};
std::vector<Rounding> roundings(const study::Study& study);
// The study with the variance of these steps, step^2 / 12, added to that of the readings.
study::Study with_rounding(study::Study study, const std::vector<Rounding>& roundings);

// Readings whose files state a standard deviation that no instrument reaches, as one in another unit than the value.
struct DoubtfulNoise {
    std::vector<std::size_t> rows;
    std::string words; // of the first, and how many
};
std::optional<DoubtfulNoise> doubtful_noise(const study::Study& study);

// One sentence for each fault of the readings and of their noise.
std::vector<std::string> fault_words(const study::Study& study);

} // namespace explore::analysis
