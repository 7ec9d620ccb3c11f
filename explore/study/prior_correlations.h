// Priors whose errors are correlated. Private to study/.
#pragma once

#include "study/study.h"

#include <toml++/toml.h>

namespace explore::study {

// The tables [[prior_correlations]]; the parameters are read. Throws pave::Error for names that are no parameter with a
// prior, a pair that appears twice, and correlations that cannot hold together.
void read_prior_correlations(const std::vector<const toml::table*>& tables, Study& study);

} // namespace explore::study
