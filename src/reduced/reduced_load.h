// The reduced model of one load: the finite element model projected on few displacement fields.
//
// Unknowns are the factors of modes that were taken from load paths of the full model. Linear layers enter exactly: the
// projection of their stiffness is linear in the entries of D. Stress-dependent layers are integrated at few of their
// Gauss points with non-negative weights (empirical cubature: Farhat et al. 2014, doi 10.1002/nme.4668), and each of
// them keeps its own stress along the path. The path, its steps and its derivatives are those of the full model
// (fe/load_path.h).
#pragma once

#include "pavement/load_model.h"
#include "reduced/basis.h"
#include "reduced/build_settings.h"

#include <functional>
#include <span>
#include <string>

namespace pave::reduced {

// Calls body(i) for i in [0, n), in any order or at once.
using ForEach = std::function<void(std::size_t n, const std::function<void(std::size_t)>& body)>;

// samples: cases of the box in random order. The first serve to build, the last to calibrate. Failure: too few of them
// have an answer.
Outcome<Basis> build(const pavement::Case& nominal, int load, std::span<const pavement::Case> samples,
                     const BuildSettings& settings, const ForEach& for_each, BuildReport* report = nullptr);

// The model of a basis. Its readings carry errors. A case that differs from the nominal one in more than it covers
// ends in a failure that says so.
std::unique_ptr<const pavement::LoadModel> make_load_model(const pavement::Case& nominal, int load, Basis basis);

} // namespace pave::reduced
