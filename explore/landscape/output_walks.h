// Walks to the ends of outputs whose runs cost far more than those of the readings: dual wheels in three dimensions
// beside a plate. Every step computes the misfit; the outputs are interpolated (inference/kriging.h, with slopes)
// between a few runs of everything, first at the minima, then at the ends that walks find, until the ends stay where
// they are and these runs confirm them.
#pragma once

#include "landscape/uniqueness.h"

namespace explore::landscape {

struct OutputWalks {
    // Down and up from each minimum for each output: all of the first output, all of the second, ... The values of
    // ends are those of runs of everything. Empty: such runs do not confirm them, or have no answer.
    std::vector<Branch> branches;
    // The outputs anywhere, interpolated between all runs; empty with the branches.
    std::function<Eigen::VectorXd(const std::vector<double>& unit)> between;
};

// from: the minima to walk from, the best first; complete: the same, each evaluated as task.everything. Chains have
// start numbers from `first` on, fewer than 100'000. Nothing: interrupted.
std::optional<OutputWalks> walk_outputs(const UniquenessTask& task, const Acceptance& acceptance,
                                        const std::vector<Minimum>& from, const std::vector<Minimum>& complete,
                                        int first);

} // namespace explore::landscape
