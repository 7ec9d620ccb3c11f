// Laws of one form, known by its numbers: what evaluates many runs at once need not ask the law.
#pragma once

#include "material/law.h"

namespace pave::material {

// E = k1_pa (thp/pa)^k2 (tau/pa + 1)^k3, at most modulus_limit, with the floor thp of material/floor.h.
struct PowerLaw {
    double k1_pa = 0.0; // Pa
    double k2 = 0.0;
    double k3 = 0.0;
    double delta = 0.0; // Pa
    double eta = 0.0;
    // Of each of those numbers: the index of the parameter that it is (k1_pa: in proportion to), -1: none.
    int k1_index = -1;
    int k2_index = -1;
    int k3_index = -1;
    int delta_index = -1;
    int eta_index = -1;
};

// The law with these parameters in that form; nothing: it has another.
std::optional<PowerLaw> power_law(const Law& law, std::span<const double> parameters);

} // namespace pave::material
