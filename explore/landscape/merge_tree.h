// The shape of a sampled landscape: its local minima, how deep each is below the pass that joins it to a lower one.
#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <span>
#include <vector>

namespace explore::landscape {

// One minimum of the sample and where its basin joins that of a lower one, when the misfit is flooded from below
// (0-dimensional persistence of the lower level sets on the graph of nearest neighbours).
struct SampledMinimum {
    std::size_t point = 0; // index of the sample
    double misfit = 0.0;
    double pass = 0.0;         // misfit at which its basin joins a lower one; infinity: it never does
    std::ptrdiff_t joins = -1; // index in the list of the minimum it joins; -1: none
    std::size_t basin = 0;     // points of the sample that drain into it before it joins another
    double persistence() const { return pass - misfit; }
};

// points: of the unit cube; misfit: not a number where there is no answer (a hole: no edge of the graph meets it). Two
// points are neighbours when one is among the `neighbours` nearest of the other. Sorted by misfit.
std::vector<SampledMinimum> merge_tree(std::span<const std::vector<double>> points, std::span<const double> misfit,
                                       int neighbours);

// The points from which a search is worth its cost: those with no better neighbour downhill. A better neighbour that
// lies uphill at first (the gradient says) is behind a ridge. Lowest first. gradients: of the misfit by the unit
// coordinates.
std::vector<std::size_t> unlinked_points(std::span<const std::vector<double>> points, std::span<const double> misfit,
                                         std::span<const Eigen::VectorXd> gradients, int neighbours);

} // namespace explore::landscape
