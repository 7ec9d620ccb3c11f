// A diagnosis as JSON and as a page.
#pragma once

#include "analysis/diagnose/diagnose.h"
#include "report/json.h"

namespace explore::report {

// The extended study, in extended.toml of the run's folder. Of a result that is_extended().
void write_extended(const analysis::DiagnoseResult& result, const analysis::RunOptions& run);

// Of a diagnosis, or {"status", "reason"} where there is none.
Json diagnose_json(const analysis::DiagnoseResult& result, const analysis::RunOptions& run);
// The content of the page, without what was computed when.
std::string diagnosis_page(const analysis::DiagnoseResult& result);
std::string diagnose_text(const analysis::DiagnoseResult& result, const analysis::RunOptions& run);

} // namespace explore::report
