// The kernels for one set of instructions: compiled once for each, PAVE_LANES its name.
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
    .functions = functions,
};

} // namespace pave::fe::lanes::PAVE_LANES
