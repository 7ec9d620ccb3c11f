// Do the sensors stand where the file says? Usual layouts, tried as a whole.
#pragma once

#include "analysis/survey/survey.h"

namespace explore::analysis {

// The usual layout of as many sensors as the file has, tried in place of its own at up to nine stations (of rising D0),
// by two searches each (from the answer there and from the middle of the box), that describes the bowls best: where the
// median RMS is beyond what sensors err (5 %) and the layout's squared misfit is less than half in the median. Linear
// sections with one layout along the road; nothing: no such layout, or another section does clearly better (the trials
// of the result).
std::optional<BetterLayout> better_layout(const SurveyResult& result);

} // namespace explore::analysis
