// A study's model behind the UM-Bridge protocol, version 1.0 (HTTP and JSON), for this machine alone.
#pragma once

#include "study/problems.h"

#include <functional>

namespace explore::report {

// Listens on this port (0: any that is free) of 127.0.0.1 and no other interface until the program is interrupted. One
// model, "forward": its one input vector the parameters in the study's order and units, its one output vector the
// readings and then the outputs, each in its unit. Evaluate, Gradient, ApplyJacobian; other requests and those with
// wrong sizes get the protocol's errors, a point without an answer InvalidInput (parameters out of range) or
// InvalidOutput. threads: that compute, 0: as many as the machine has. ready: called with the address once it is
// reachable. Throws pave::Error for a port that is taken.
void serve_model(const study::Study& study, int port, int threads,
                 const std::function<void(const std::string& address)>& ready);

} // namespace explore::report
