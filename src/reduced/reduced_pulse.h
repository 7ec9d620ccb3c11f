// The reduced model of a load with a history.
#pragma once

#include "pavement/load_model.h"
#include "reduced/basis.h"

namespace pave::reduced {

std::unique_ptr<const pavement::LoadModel> make_pulse(const pavement::Case& nominal, int load, Basis basis);

} // namespace pave::reduced
