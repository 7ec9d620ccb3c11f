// Local search that uses the structure of least squares: Levenberg-Marquardt steps inside the unit cube.
#pragma once

#include "optimise/local_search.h"

namespace explore::optimise {

// Every step minimises |r + J d|^2 + damping |d|^2 over the steps d that stay in the cube (an active set method), with
// the damping of Nielsen (1999): lowered by how well the model predicted the gain, raised when a step fails or leads to
// a point without an answer. The residuals' own curvature enters through a structured secant matrix (Dennis, Gay and
// Welsch 1981, their NL2SOL) once two Jacobians are known, where it helps to predict the gain.
SearchResult gauss_newton(const std::vector<double>& start, const Objective& objective, const SearchSettings& settings);

} // namespace explore::optimise
