// Another bottom of the section, where an effect that was found reads like one.
#pragma once

#include "analysis/diagnose/diagnose.h"

#include <string>

namespace explore::analysis {

// Whether a floor as deep as is tried, alone, takes away most of what the study's model leaves beyond noise.
bool is_floor_sought_deepest(const DiagnoseResult& result);

// The other meaning of a subgrade that stiffens with depth or is soft on top in a study that has nothing below it, and
// of a floor that lies as deep as is tried; "": neither.
std::string bottom_hint(const DiagnoseResult& result);

} // namespace explore::analysis
