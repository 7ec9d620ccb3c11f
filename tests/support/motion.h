// A section marched through the history of its first load, with what went into it and out of it.
#pragma once

#include "pavement/load_model.h"
#include "pavement/pulse.h"

namespace test {

template <class Kind>
pave::fe::Marched<typename Kind::Element> marched_until(pave::pavement::Case c,
                                                        std::vector<pave::pavement::Load::Sample> history) {
    c.loads[0].history = std::move(history);
    const auto parts = pave::pavement::parts_of<Kind>(c, 0);
    pave::fe::Solver<typename Kind::Element> solver(parts.model);
    auto marched = solver.pulse(parts.layers, parts.load, pave::pavement::pulse_of(c, 0), {}, {}, {});
    return std::move(marched).value();
}

} // namespace test
