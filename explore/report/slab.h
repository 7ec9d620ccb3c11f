// Concrete slabs as JSON and as text.
#pragma once

#include "analysis/survey/slab.h"
#include "report/answer.h"

namespace explore::report {

Json slab_json(const analysis::SlabResult& result);
Answer slab_answer(const analysis::SlabResult& result);
std::string slab_text(const analysis::SlabResult& result);

} // namespace explore::report
