// The catalogue of effects as JSON and as a page.
#pragma once

#include "report/answer.h"

namespace explore::report {

Json effects_json();
Answer effects_answer();
std::string effects_text();

} // namespace explore::report
