// The model between the sensors, as JSON.
#pragma once

#include "analysis/common/curves.h"
#include "report/json.h"

namespace explore::report {

// [{"load", "quantity", "by_depth", "x_mm", "y_mm", "depth_mm", "gauge_mm", "unit", "to_si", "at_mm", "values"}]
Json curves_json(const std::vector<analysis::Curve>& curves);

} // namespace explore::report
