// Synthetic data as a measurement file and as JSON.
#pragma once

#include "analysis/studies/twin.h"
#include "report/json.h"

namespace explore::report {

std::string twin_csv(const analysis::TwinResult& twin);
Json twin_json(const analysis::TwinResult& twin, const std::string& file);

} // namespace explore::report
