// Directions that the derivatives at a fit leave open, and along which chi2 may rise all the same.
//
// A volume to first order is then that of the whole prior, and intervals reach over the whole box, though the data end
// them on the way (a valley that bends, a parameter that matters at another stiffness only).
#pragma once

#include "diagnose/workbench.h"

namespace explore::diagnose {

// Rows that stand beside the derivatives of the residuals, in their unit: along each direction that these leave open
// (crossing the standard deviation of the box raises chi2 by less than 4), as much curvature as is seen one such
// deviation away, or where chi2 has risen by what an interval ends at, the other directions making the best of it. Of
// no rows where all is as first order says. variance: of a residual.
Eigen::MatrixXd rows_of_open_directions(const problem::Problem& problem, const Model& model, double variance,
                                        run::Chain& chain);

} // namespace explore::diagnose
