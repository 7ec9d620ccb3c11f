// The kernels for one set of instructions: compiled once for each, PAVE_LANES its name.
#include "fe/lanes/dense.h"
#include "fe/lanes/path.h"

namespace pave::fe::lanes::PAVE_LANES {

extern const Kernels table;
const Kernels table{
    .instructions = PAVE_LANES_NAME,
    .lanes = width,
    .rounds_once = is_fused,
    .assemble = assemble,
    .eliminate = eliminate,
    .forward = forward,
    .backward = backward,
    .moduli = moduli,
    .stress = stress_of,
    .add_stress_rates = add_stress_rates,
    .subtract_force = subtract_force_of,
    .subtract_stress = subtract_stress,
    .shares = shares,
    .combine = combine,
    .eliminate_dense = eliminate_dense,
    .invert_dense = invert_dense,
    .forward_dense = forward_dense,
    .backward_dense = backward_dense,
    .forward_one = forward_one,
    .backward_one = backward_one,
    .functions = functions,
};

} // namespace pave::fe::lanes::PAVE_LANES
