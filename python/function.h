// A Python function as the model of a study.
#pragma once

#include "external/simulator.h"

#include <memory>
#include <pybind11/pybind11.h>

namespace python {

struct FunctionOf {
    // Of a float64 array with a value a parameter: a float64 array of responses in their units, or why there are none,
    // as text. It raises nothing but what ends the interpreter.
    pybind11::object function;
    pybind11::object jacobian; // the same with responses x parameters; None: differences
    std::string identity = {}; // of what they compute, for the store
    std::size_t parameters = 0, responses = 0;
};
// Called with the interpreter's lock, from any thread; that thread holds it during the call alone.
std::shared_ptr<const explore::external::Simulator> make_simulator(FunctionOf of);

} // namespace python
