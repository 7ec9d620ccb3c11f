// The fitted readings of a study as the residuals of its problem: their groups, and what is left out together.
#pragma once

#include "diagnose/diagnosis.h"
#include "landscape/uniqueness.h"
#include "study/problems.h"

namespace explore::analysis {

// Residuals are the fitted readings in the order of the study's groups.
struct Layout {
    std::vector<std::size_t> rows; // the reading of each residual
    std::vector<diagnose::ReadingGroup> groups;
    std::vector<diagnose::Fold> places, loads; // places: at most ten, those beyond share them
};

Layout layout_of(const study::Study& study);

// The use of the study's weights where noise is stated; "": nothing to say.
std::string weights_words(const study::Study& study);

// Which of the study's keys of noise take effect where readings state a sigma of their own; "": nothing to say.
std::string noise_key_words(const study::Study& study);

// Why fit and unique differ where noise is stated but the misfit ignores it; "" where they agree.
std::string misfit_words(const study::Study& study);

// Root mean square of the residuals of the readings that the study holds out, in standard deviations of their stated
// noise; none where nothing is held out or no noise is stated. responses: of all readings.
std::optional<double> held_out_rms(const study::Study& study, const std::vector<double>& responses);

// Whether an output is of a load with far more unknowns than those that a problem of what is fitted computes.
bool outputs_cost_more(const study::Study& study);

// The question of uniqueness for a study: the ranges of its outputs, and whether its groups agree. All but the study
// must outlive the task; problems: study::make_noise_problem of what is fitted and of everything.
landscape::UniquenessTask uniqueness_task(const study::Study& study, const problem::Problem& fitted,
                                          const problem::Problem& everything, run::Engine& fitted_engine,
                                          run::Engine& everything_engine, std::uint64_t seed);

} // namespace explore::analysis
