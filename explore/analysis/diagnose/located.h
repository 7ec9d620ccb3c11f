// Corrections found by a diagnosis in the units of an engineer.
#pragma once

#include "diagnose/diagnosis.h"
#include "study/study.h"

#include <optional>

namespace explore::analysis {

// The factor on the modulus (of a channel of readings: on the readings) at one place, with its 95 % band, to first
// order: the corrected model's over that of the study's fitted model, both by the law at the stress that acts there, so
// that what parameters and coefficients share counts once.
struct LocatedPlace {
    double at = 0.0; // in the unit of the channel
    double value = 1.0, low = 1.0, high = 1.0;
    double modulus = 0.0;       // Pa, of the corrected model; 0: of readings
    double variance_left = 1.0; // of ln(value), over what was thought possible beforehand

    // The readings know it: of what was thought possible they leave less than a quarter, and no more than a factor of
    // two between the ends of the band, however much was thought possible.
    bool seen() const { return variance_left < enough && high <= 2.0 * low; }
    // Which side of 1 it lies on for certain; 0: neither.
    int side() const { return variance_left >= enough ? 0 : high < 1.0 ? -1 : low > 1.0 ? 1 : 0; }

    static constexpr double enough = 0.25;
};

// The factor at one place over that at another, with its 95 % band: known where the readings do not say which of the
// two is off, because a parameter makes up for what they have in common.
struct LocatedContrast {
    std::size_t place = 0, beside = 0; // of the two the one with the smaller factor, and the other
    double value = 1.0, low = 1.0, high = 1.0;
};

struct LocatedCorrection {
    pave::pavement::Correction correction; // its factors those found
    double strength = 0.0;                 // see diagnose::Correction
    std::vector<LocatedPlace> places;
    // Of the two places that are told apart most clearly; none: no two are.
    std::optional<LocatedContrast> contrast{};

    diagnose::Says says_where() const;
};

// The corrections among the members of a model, all factors 1. channels: those of the diagnosis.
std::vector<std::size_t> channels_of(const std::vector<diagnose::Channel>& channels, const diagnose::Members& members);

// One each of location.corrections. corrected: the study with them as parameters; problem: of it.
std::vector<LocatedCorrection> located(const study::Study& study, const study::Study& corrected,
                                       const problem::Problem& problem, const diagnose::Diagnosis& d,
                                       const std::vector<diagnose::Channel>& channels,
                                       const std::vector<pave::pavement::Correction>& corrections);

// "Between 200 and 400 mm below its top the subgrade has 45 to 65 % of the modulus of the study's model"; what is seen
// to differ, at places or between two of them, then what is not seen. Empty: nothing of either.
std::vector<std::string> words_of(const LocatedCorrection& found);
// "subgrade, by depth"
std::string channel_words(const pave::pavement::Correction& correction);

} // namespace explore::analysis
