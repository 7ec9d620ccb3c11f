// Local search that uses the structure of least squares: Gauss-Newton steps inside the unit cube and a trust region.
#pragma once

#include "optimise/local_search.h"

namespace explore::optimise {

// Every step minimises |r + J d|^2 over the steps d that stay in the cube and are no longer than a radius (Moré 1978,
// with damping in place of the radius; optimise/quadratic.h), which grows and falls with how well the linear rows
// predicted the gain. The residuals' own curvature enters through a structured secant matrix (Dennis, Gay and Welsch
// 1981, their NL2SOL) once two Jacobians are known, where it helps to predict the gain.
//
// Rows that weigh far more than the others make a narrow, curved valley, which a step along it leaves though it leads
// somewhere better. Before such a step is given up, shorter ones from its end return to the valley, and both together
// are judged (the watchdog of Chamberlain, Powell, Lemarechal and Pedersen 1982, Mathematical Programming Study 16).
//
// The search has converged where the whole step, by no radius, promises a gain that does not matter, or is itself
// short.
SearchResult gauss_newton(const std::vector<double>& start, const Objective& objective, const SearchSettings& settings);

} // namespace explore::optimise
