// Studies that differ from a user's in the law of one layer.
#pragma once

#include "study/study.h"

namespace explore::study {

// The layers whose law depends on stress, by number.
std::vector<std::size_t> stress_dependent_layers(const Study& study);

// The study with another law in a layer. Keys that both laws have keep value and range (an isotropic law's `poisson`
// and `poisson_31` count as one key); parameters of the old law alone are gone; what a fit of the new law varies and
// the old law does not have is varied over its usual range. With the layer's own law: the study as it is. Throws
// pave::Error at `place` when an effect of the study cannot act on that law, or nothing is left to vary.
Study with_law(Study study, std::size_t layer, const pave::material::Law& law, const pave::Place& place);

} // namespace explore::study
