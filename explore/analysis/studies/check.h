// The cost of a study: which runs it needs, and for how long.
#pragma once

#include "base/outcome.h"
#include "study/problems.h"

namespace explore::analysis {

// The estimate for a command.
struct Estimate {
    std::string command;
    std::string runs; // "256, then 120 with derivatives"
    double seconds = 0.0;
};

// The basis of an estimate.
enum class Timing {
    sizes, // of the meshes: at once, within a factor of a few
    runs   // made now at the study's own values
};

// For so many threads. Failure: runs were made, and there is no answer. Throws pave::Error for what every command that
// fits would complain of.
pave::Outcome<std::vector<Estimate>> check(const study::Study& study, int threads, Timing timing);

// A sentence on readings that no pavement has: a deflection above 20 mm or as far upwards as 2 mm, a strain above 5
// %, a stress above 10 MPa; and on loads that none bears: pressures, and how long they act.
std::vector<std::string> doubtful_readings(const study::Study& study);

} // namespace explore::analysis
