// Is the answer unique, along what is it not, and what does that do to the outputs?
#pragma once

#include "analysis/common/curves.h"
#include "analysis/common/load_steps.h"
#include "analysis/common/mesh_error.h"
#include "analysis/common/next_reading.h"
#include "analysis/common/output_ranges.h"
#include "analysis/common/posterior_range.h"
#include "analysis/common/session.h"
#include "landscape/pair_profile.h"

namespace explore::analysis {

struct UniqueOptions {
    ModelOptions model{};
    landscape::UniquenessSettings settings{};
    bool landscape = false; // with the full model too
    bool posterior = false; // draw it, and hold its ranges against those that were walked
};

// The rise of chi2 over pairs of parameters, all others fitted. Without one, where it was not requested or cannot be
// said: nothing.
struct UniqueLandscape {
    landscape::ProfiledLandscape profiled;
    bool by_reduced_model = false;
    double limit = 0.0; // rise that the data accept
    std::int64_t runs = 0;
};

struct UniqueResult {
    study::Study study;
    UniqueOptions options;
    problem::Problem problem; // residuals in units of their noise where it is stated
    landscape::Uniqueness answer;
    NextReading next;
    std::optional<UniqueLandscape> landscape;
    std::optional<MeshError> mesh;
    std::optional<PathError> path{};
    std::vector<OutputUncertainty> outputs;
    std::optional<PosteriorRanges> posterior; // nothing: not requested, or no range was walked
    std::optional<ReducedProblem> reduced;
    std::vector<Curve> curves; // of the best minimum, by the full model; of the reduced model alone none
    std::int64_t computed = 0; // runs of this process
    std::int64_t kept = 0;     // runs that were in the store
    std::int64_t computed_by_reduced_model = 0;
    double seconds = 0.0;
    double forward_cpu_seconds = 0.0;

    bool failed() const { return answer.minima.empty(); }
    std::string reason() const; // of failed()
    const landscape::Minimum& best() const { return answer.minima[0]; }
};

// Throws pave::Error for a study that cannot be fitted. Nothing: interrupted.
std::optional<UniqueResult> unique(Session& session, const study::Study& study, const UniqueOptions& options);

// The verdict and its reasons, in sentences.
std::vector<std::string> findings(const UniqueResult& result);

// "base.k1 * (theta/pa)^base.k2 at theta = 62 kPa is fixed to 2 %": a combination in the terms of the laws. unit: where
// it was found.
std::string combination_words(const study::Study& study, const landscape::Combination& combination,
                              const std::vector<double>& unit);
// "higher base.k1 and lower base.n": what one group of data wants of another. direction: in the unit cube; "": none.
std::string conflict_words(const problem::ParameterSpace& space, const Eigen::VectorXd& direction);
// Why a walk ended: "the data", "base.n at its upper bound". bounds: that it met, in words of the caller's.
std::string end_words(landscape::WalkEnd end, const std::vector<std::string>& bounds);
std::string end_words(const problem::Problem& problem, landscape::WalkEnd end,
                      const std::vector<landscape::BoundMet>& bounds, const std::vector<std::size_t>& limits);
std::vector<std::string> names_of(const problem::ParameterSpace& space, const std::vector<std::size_t>& axes);

} // namespace explore::analysis
