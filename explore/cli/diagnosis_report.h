// What `pavescape diagnose` says of a diagnosis: its page and its JSON.
#pragma once

#include "cli/layout.h"
#include "report/json.h"
#include "study/variants.h"

namespace explore::cli {

// A model of the diagnosis with everything a report asks of it.
struct Reported {
    study::Study study; // with the effects, their sizes free
    problem::Evaluation evaluation;
    double misfit = 0.0;                        // the study's own
    std::vector<diagnose::Interval> parameters; // the effects' sizes last
    std::optional<double> held_out_rms;         // of the readings the study holds out, standard deviations
    std::size_t held_out = 0;
};

// One reading that would separate what the data leave ambiguous.
struct Separating {
    std::string reading, unit;
    double sigma = 0.0;
    std::vector<double> values; // foretold by each explanation
    double power = 0.0;         // the rate of the right decision between the best explanation and its closest rival
    double rate_now = 0.0;      // the same with the present readings
};

// All that is told.
struct Findings {
    const study::Study& study;
    const std::vector<study::Variant>& variants;
    const std::vector<diagnose::Candidate>& candidates;
    const Layout& layout;
    const diagnose::Diagnosis& d;
    const Reported& before;
    const std::optional<Reported>& after;
    const std::vector<Separating>& next;
    const std::vector<std::optional<double>>& held_out; // of each explanation: see Reported
    const std::string& extended_path;                   // of the extended study; empty: none
};

report::Json diagnosis_json(const Findings& f);
std::string diagnosis_page(const Findings& f);

} // namespace explore::cli
