// Criteria of a study: what its pavement fails by, and under how much traffic.
#pragma once

#include "pavement/criteria.h"
#include "study/study.h"

namespace explore::study {

struct Criterion {
    std::string name, law;
    const pave::pavement::CriterionLaw* guide = nullptr; // none: by the expression
    std::optional<pave::Expression> life{};              // of strain and modulus
    std::vector<double> options{};                       // of the guide's law
    pave::pavement::CriticalPlace place = pave::pavement::CriticalPlace::subgrade_top;
    std::size_t load = 0;                // of the study: the axle
    std::size_t layer = 0;               // of the study: at whose bottom or top
    std::optional<double> modulus_MPa{}; // none: that of the layer, where it is read
    double traffic_per_year = 0.0;
    double growth = 0.0;
    double passed = 0.0;
    std::optional<double> design_traffic{};
    int line = 0;

    bool reads_modulus() const;
    double depth(const pave::pavement::Case& c) const; // m, of its place
    // Traffic of so many years from now, and how many years so much traffic takes; infinity: never, it dies out.
    double traffic_of(double years) const;
    double years_of(double repetitions) const;
    // ln of the allowable repetitions.
    double log_repetitions(const pave::pavement::CriterionState& state) const;
};

// The [[criteria]] of the text of a study. Throws pave::Error.
std::vector<Criterion> criteria_of(const Study& study);

} // namespace explore::study
