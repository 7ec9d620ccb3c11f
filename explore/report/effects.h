// The catalogue of effects as JSON and as a page.
#pragma once

#include "report/json.h"

namespace explore::report {

Json effects_json();
std::string effects_text();

} // namespace explore::report
