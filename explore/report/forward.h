// A forward run at a study's own values as JSON and as a page of the terminal.
#pragma once

#include "analysis/studies/point_list.h"
#include "base/outcome.h"
#include "pavement/forward.h"
#include "report/answer.h"
#include "study/values.h"

namespace explore::report {

// model: none of a study with its own. values: of the study that were set to others.
Json forward_json(const study::Study& study, const pave::pavement::ForwardModel* model,
                  const pave::Outcome<pave::pavement::Response>& outcome, const std::vector<study::NamedValue>& values);
// Of a run with an answer. fields: files of them that were written.
Answer forward_answer(const study::Study& study, const pave::pavement::Response& response,
                      const std::vector<study::NamedValue>& values, const std::vector<std::string>& fields);
std::string forward_text(const study::Study& study, const pave::pavement::Response& response,
                         const std::vector<study::NamedValue>& values, const std::vector<std::string>& fields);
// A line a point: its values, the readings and outputs there, and how it ended.
std::string points_csv(const study::Study& study, const analysis::ComputedPoints& computed);
Json points_json(const study::Study& study, const analysis::ComputedPoints& computed);
// The table of its derivatives.
std::string jacobian_text(const study::Study& study, const pave::pavement::Response& response);

} // namespace explore::report
