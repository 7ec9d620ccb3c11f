// The commands that a study can run and how long they take, as JSON and as an answer of the terminal.
#pragma once

#include "analysis/studies/check.h"
#include "report/answer.h"

namespace explore::report {

struct CheckedStudy {
    const study::Study& study;
    const std::vector<analysis::Estimate>& commands;
    int threads = 1;
    bool is_timed = false;                     // by runs
    pave::pavement::ForwardModel::Cost cost{}; // of a run
};

Json check_json(const CheckedStudy& checked);
Answer check_answer(const CheckedStudy& checked);
std::string check_text(const CheckedStudy& checked);

} // namespace explore::report
