// What would run on a study, and for how long.
#pragma once

#include "base/outcome.h"
#include "study/problems.h"

namespace explore::analysis {

// What a command takes.
struct Estimate {
    std::string command;
    std::string runs; // in words
    double seconds = 0.0;
};

// From runs made now at the study's own values, for so many threads. Failure: no answer there. Throws pave::Error for
// what every command that fits would complain of.
pave::Outcome<std::vector<Estimate>> check(const study::Study& study, int threads);

// What is said of readings that no pavement has: a deflection above 20 mm or as far upwards as 2 mm, a strain above 5
// %, a stress above 10 MPa.
std::vector<std::string> doubtful_readings(const study::Study& study);

} // namespace explore::analysis
