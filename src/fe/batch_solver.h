// Many load paths on one axisymmetric mesh side by side, a lane of the processor's vectors each.
//
// The same steps as those of Solver::incremental: the matrices of all runs have one pattern, so that elimination,
// solutions, laws and assembly do the same operations on other numbers. The bits of a run are the same whatever runs
// beside it and however many; they differ from those of Solver::incremental by rounding (another order of sums), and
// between processors with and without fused multiplication.
#pragma once

#include "fe/solver.h"

#include <span>

namespace pave::fe {

// One of the runs. All refer to the same laws in the same layers.
struct BatchRun {
    const std::vector<LayerMaterial>* layers = nullptr;
    const Eigen::VectorXd* load = nullptr; // force on every free unknown [N]
    const std::vector<Functional<AxisymmetricQ8>>* readings = nullptr;
};

// Readings under the load with their derivatives: a course of one instant.
struct BatchReading {
    Course at_rest;
    Statistics statistics;
};

namespace lanes {
struct Kernels;
}

// One object a thread; keeps its buffers between calls.
class BatchSolver {
public:
    using Element = AxisymmetricQ8;

    // Whether it follows such runs: bonded layers, at least one of which is stress-dependent, along the load path, none
    // with fields, a C that turns, relaxation or an energy; differentiated by parameters of laws, initial stress and a
    // factor on the load.
    static bool serves(const Model<Element>& model, const std::vector<LayerMaterial>& layers,
                       const std::vector<Variation>& variations);
    // How many runs go together at most.
    static int lanes();
    // Whether this processor rounds a product and a sum once: what bits depend on.
    static bool rounds_once();

    // kernels: nullptr: those of the processor, no wider than the runs at hand need.
    explicit BatchSolver(const Model<Element>& model, const lanes::Kernels* kernels = nullptr);
    ~BatchSolver();

    // The same structure with other node positions; `model` shares the topology of the one before.
    void move(const Model<Element>& model);

    // Any number of runs, each of which it serves. A limit of time counts for the runs that go together.
    std::vector<Outcome<BatchReading>> incremental(std::span<const BatchRun> runs,
                                                   const std::vector<Variation>& variations,
                                                   const SolverSettings& settings);
    // Bytes that it holds.
    std::size_t memory() const;

private:
    struct Work;
    Work& work_for(std::size_t runs);

    const Model<Element>* model_;
    const lanes::Kernels* kernels_;
    std::vector<std::unique_ptr<Work>> works_; // of a width each, made when first needed
};

} // namespace pave::fe
