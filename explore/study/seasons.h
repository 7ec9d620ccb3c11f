// Seasons of a study: shares of the year's traffic over layers that are stiffer or softer than when readings were
// taken.
#pragma once

#include "study/study.h"

namespace explore::study {

struct Season {
    std::string name;
    double share = 0.0;          // of the year's traffic; those of all seasons add up to 1
    std::vector<double> factors; // of each layer: its stiffness over that at the time of the readings
};

// The [[seasons]] of the text of a study; none: the pavement is all year as it was read. Throws pave::Error.
std::vector<Season> seasons_of(const Study& study);

// Which parameter of a layer's law its moduli are proportional to: an index of law->parameters(). Nothing: no single
// one.
std::optional<std::size_t> stiffness_of(const pave::pavement::Layer& layer);

// Makes the layers of a case of the study as they are in that season.
void soften(pave::pavement::Case& c, const Season& season);

// The value of each parameter of the study in that season is one of 1 at the time of the readings.
std::vector<double> parameter_factors(const Study& study, const Season& season);

} // namespace explore::study
