// How well a prediction is known at a minimum.
#pragma once

#include "landscape/minima.h"

namespace explore::landscape {

// Standard error, to first order, of a quantity with this gradient by the unit coordinates: of g' J^+ times the noise
// of the residuals, with the jacobian and the noise (widened where it is contradicted) that local.standard_error is
// made of; for the gradient of a parameter it is that. Infinity: the quantity moves in a direction that the readings do
// not see, or the noise is not known. local: of the minimum, by analyse().
double prediction_error(const Eigen::VectorXd& gradient, const Minimum& minimum, const problem::Problem& problem,
                        const LocalAnalysis& local);

} // namespace explore::landscape
