// The input of the page of `explore`, as JSON; numbers in the units of the study, null where there is none.
#pragma once

#include "analysis/explore/explore.h"
#include "report/json.h"

namespace explore::report {

// {"study", "version", "model", "model_words", "seconds_a_point", "parameters": [{"name", "words", "min", "max",
// "scale", "start"}], "readings": [place, "measured", "unit", "sigma", "fitted", "words"], "outputs": [{"name",
// "unit"}], "noise", "degrees_of_freedom", "limit": the rise of chi2 that the data accept, "minima", "curves": of the
// full model at the best}. minima: as minimum_json with "chi2", "at" (values in the order of the parameters) and
// "p_value".
Json explore_state_json(const analysis::Explorer& explorer);

// {"status", ("reason"), "at", "chi2", "values": of the readings, "residuals" of them, "outputs", "full": whether the
// full model answered, "warnings"}
Json explore_point_json(analysis::Explorer& explorer, const problem::Evaluation& evaluation,
                        const analysis::ChangedReadings& changes);
// {"minimum": as in the state, "point"}, or {"status": "no answer"}.
Json explore_fit_json(analysis::Explorer& explorer, const std::optional<analysis::FoundMinimum>& found,
                      const analysis::ChangedReadings& changes);
// {"x", "y", "x_values", "y_values", "chi2": [rows], "lowest", "fitted"}, or {"status": "given up"}.
Json explore_landscape_json(const analysis::Explorer& explorer, const std::optional<analysis::PairGrid>& grid);
// As a point, with "curves" and "seconds".
Json explore_confirm_json(analysis::Explorer& explorer, const analysis::ConfirmedPoint& point,
                          const analysis::ChangedReadings& changes);

} // namespace explore::report
