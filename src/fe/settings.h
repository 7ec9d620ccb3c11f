// How exactly the solvers work.
#pragma once

#include <limits>

namespace pave::fe {

struct SolverSettings {
    // incremental: of the load path of every load, however it is modelled. The error goes with their number to the
    // power -3.
    int load_steps = 9;
    // secant, hyperelastic: unbalanced force relative to the load.
    double equilibrium_tolerance = 1e-9;
    // Error of an iterative solution of one linear system in the energy norm, relative to the solution (3D): well below
    // what the load path leaves. What adds up along a load path is brought back to equilibrium at its end.
    double linear_tolerance = 1e-4;
    double time_limit = std::numeric_limits<double>::infinity(); // s, of a load path: beyond it fails
};

} // namespace pave::fe
