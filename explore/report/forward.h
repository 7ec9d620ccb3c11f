// A forward run at a study's own values as JSON and as a page of the terminal.
#pragma once

#include "analysis/point_list.h"
#include "pavement/forward.h"
#include "report/json.h"

namespace explore::report {

Json forward_json(const study::Study& study, const pave::pavement::ForwardModel& model,
                  const pave::Outcome<pave::pavement::Response>& outcome);
// Of a run with an answer.
std::string forward_text(const study::Study& study, const pave::pavement::Response& response);
// A line a point: its values, the readings and outputs there, and how it ended.
std::string points_csv(const study::Study& study, const analysis::ComputedPoints& computed);
Json points_json(const study::Study& study, const analysis::ComputedPoints& computed);
// The table of its derivatives.
std::string jacobian_text(const study::Study& study, const pave::pavement::Response& response);

} // namespace explore::report
