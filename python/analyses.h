// The analyses of the command line as methods of a study, and those of a road as functions of the module.
#pragma once

#include "study.h"

namespace python {

void add_analyses(pybind11::module_& m, pybind11::class_<Study>& study);

} // namespace python
