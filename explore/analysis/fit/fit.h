// Fit: explore, then refine the best distinct starts.
#pragma once

#include "analysis/common/curves.h"
#include "analysis/common/drift.h"
#include "analysis/common/floor.h"
#include "analysis/common/groups.h"
#include "analysis/common/load_steps.h"
#include "analysis/common/mesh_error.h"
#include "landscape/held_ranges.h"
#include "landscape/prior_influence.h"
#include "problem/noise_scale.h"

namespace explore::analysis {

// Points of a Sobol sample when nothing else is requested.
inline constexpr int fit_points = 256;

enum class Scheme {
    multistart, // a Sobol sample and several starts
    paper       // a coarse full grid, and one search from its smallest misfit
};
inline constexpr std::string_view scheme_names[] = {"multistart", "paper"};

struct FitOptions {
    ModelOptions model{};
    Scheme scheme = Scheme::multistart;
    int explore = fit_points;
    bool joint_only = false; // no fits of one group of readings alone
    landscape::MultistartSettings multistart{};
    std::vector<std::vector<double>> starts{}; // further ones than the best points of the sample, unit coordinates
};

struct FitResult {
    study::Study study;
    FitOptions options;
    problem::Problem problem;
    search::Design design;
    landscape::MultistartResult searches; // the best minimum with the responses of every load; no minima: no answer
    landscape::LocalAnalysis local;       // at the best minimum
    landscape::HeldRanges held{};         // its ranges where inequalities cut them
    std::optional<GroupFit> joint;
    std::vector<GroupFit> alone;
    std::optional<ReducedProblem> reduced;
    std::optional<WithoutFloor> without_floor;
    std::optional<MeshError> mesh;
    std::optional<PathError> path{};
    std::vector<SensorDrift> drifts;
    std::optional<landscape::PriorInfluence> priors;
    std::vector<Curve> curves; // of the best minimum, by the full model; of the reduced model alone none
    run::Tally tally;
    double seconds_by_reduced_model = 0.0;

    const landscape::Minimum& best() const { return searches.minima[0]; }
    bool failed() const { return searches.minima.empty(); }
    std::string reason() const; // of failed()
    // Nothing: it is not sought, or no degrees of freedom tell it.
    std::optional<problem::NoiseScale> noise_scale() const;
    // Whether the readings leave a parameter of the best minimum about as unknown as it was: within the study's range,
    // cut by no inequality, and with a 95 % range of half of what the study allows or more.
    bool leaves_unknown(std::size_t parameter) const;
};

// Throws pave::Error for a study that cannot be fitted so. Nothing: interrupted.
std::optional<FitResult> fit(Session& session, const study::Study& study, const FitOptions& options);

// The weight of each squared residual, in the weighted least squares with the same answer, beside normal
// noise (problem/student.h): 1 each with normal noise.
std::vector<double> reading_weights(const problem::Problem& problem, const problem::Evaluation& evaluation);

// The ends of the searches, in sentences.
std::vector<std::string> findings(const FitResult& result);

} // namespace explore::analysis
