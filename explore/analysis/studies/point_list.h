// Parameter sets of a file, and the model at each of them.
#pragma once

#include "base/outcome.h"
#include "study/study.h"

#include <optional>

namespace explore::analysis {

// A header with names, a set a line. Files that this program wrote (samples.csv, what `export` prints) hold other
// columns, too.
struct PointList {
    std::vector<std::string> names;
    std::vector<std::vector<double>> values; // a row a set, in the units of the study
    std::vector<int> lines;                  // of the file
    std::vector<double> misfit;              // of each, where the file states it; else empty
};
// known: names that columns may have. Throws pave::Error for anything wrong in the file.
PointList read_points(const std::string& file, const std::vector<std::string>& known);

struct ComputedPoints {
    PointList points;
    std::vector<pave::Outcome<std::vector<double>>> responses; // SI
    std::vector<std::vector<std::string>> warnings;
};
// Every reading and output of the study at every point, numbers that the file does not name at the study's own values.
// Nothing: interrupted.
std::optional<ComputedPoints> compute_points(study::Study study, PointList points, const std::string& file,
                                             int threads);

} // namespace explore::analysis
