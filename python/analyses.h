// The analyses of the command line, as JSON text and arrays: what pavescape/ makes objects of.
#pragma once

#include "study.h"

namespace python {

void add_fits(pybind11::class_<Study>& study);
void add_judgements(pybind11::class_<Study>& study);
void add_roads(pybind11::module_& m);
void add_pages(pybind11::module_& m);

} // namespace python
