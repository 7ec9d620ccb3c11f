// Readings of which a limit is known, in words.
#pragma once

#include "study/study.h"

#include <string>

namespace explore::analysis {

// "One reading is a limit (fwd.deflection@1800,0,0 < 0.012 mm): it adds ..."; "": none is.
std::string limit_words(const study::Study& study);

} // namespace explore::analysis
