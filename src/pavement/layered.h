// The model of a load by the layered engine: linear layers under circles, without a mesh.
#pragma once

#include "pavement/load_model.h"

namespace pave::pavement {

// Why the layered engine cannot compute a load of a case without effects, or "": it needs linear layers that are the
// same all over, circles of pressure, and no mass or stiffness of a plate.
std::string why_not_layered(const Case& c, int load);

// There is no lateral wall. Fields come from finite elements. The load's geometry may change from run to run.
std::unique_ptr<const LoadModel> make_layered_model(const Case& nominal, int load);

} // namespace pave::pavement
