// The posterior of the parameters and the outputs, by sampling.
#pragma once

#include "analysis/common/candidate_readings.h"
#include "analysis/common/session.h"
#include "analysis/sample/predictive.h"
#include "analysis/sample/sampled_outputs.h"
#include "landscape/posterior.h"
#include "landscape/prior_influence.h"
#include "problem/noise_scale.h"

namespace explore::analysis {

struct SampleOptions {
    ModelOptions model{};
    bool any_model = true; // model.use is not requested: `automatic` where the study has a reduced model, else `full`
    int samples = 2000;    // draws, of all populations
    // Draws at which the full model corrects the sample of a reduced model, and at most those at which it computes
    // outputs under loads that no reading has.
    int confirm = 500;
};

enum class SampleStatus {
    converged,
    not_converged, // the draws say too little, or populations disagree: no quantile is given
    failed         // no draw
};
inline constexpr std::string_view sample_status_names[] = {"converged", "not-converged", "failed"};

struct SampledDraw {
    std::vector<double> unit, parameters; // parameters: physical
    std::vector<double> outputs;          // SI; empty: not computed here
    std::vector<double> readings;         // SI, as the model gives them; empty: it was not run here
    double log_likelihood = 0.0;          // of the model that is reported
    double chi2 = 0.0;                    // of its residuals by that model; not a number: it was not run here
};

// Draws of a reduced model, weighed to be those of the full one by the ratio of the likelihoods: where the full model
// ran by its own, elsewhere by a smooth surface through those (landscape/smooth.h), or left out where that does not
// hold.
struct SampleCorrection {
    std::size_t runs = 0;
    std::size_t without_answer = 0;
    std::size_t weighed = 0; // draws that are kept
    double effective = 0.0;  // of them, by their weights
    double left = 0.0;       // of the logarithms of the weights, beyond the surface; not a number: there is none
};

struct SampleResult {
    study::Study study;
    SampleOptions options;          // with the model that was used
    problem::Problem problem;       // that the posterior is of
    landscape::Posterior posterior; // as it was sampled, by the reduced model where that is used
    std::vector<SampledDraw> draws{};
    landscape::Descent descent{};                        // of the draws
    std::vector<landscape::Marginal> parameters{};       // physical
    std::vector<landscape::Marginal> outputs{};          // SI; empty: none computed
    std::vector<std::size_t> besides{};                  // rows of outputs under loads that no reading has
    std::optional<OutputSurface> surface{};              // of those; nothing: none, or none is good enough
    double log_evidence = 0.0, log_evidence_error = 0.0; // relative to what the constraints leave of the prior
    std::optional<landscape::AllowedShare> allowed{};    // that; nothing: no constraint, or it could not be estimated
    // The lowest of a draw; where priors or constraints hold the answer that of the readings by themselves.
    double chi2 = 0.0;
    int degrees_of_freedom = 0;
    double p_value = 1.0; // of that chi2; 1 without degrees of freedom, and where the size of the noise is fitted
    std::optional<problem::NoiseScale> noise_scale{};  // where it is fitted
    std::optional<landscape::Minimum> held{};          // the best point, where priors or constraints hold it
    std::optional<landscape::PriorInfluence> priors{}; // there
    std::vector<PredictedReading> predicted{};         // by the draws that were run, with their noise
    std::optional<SampleCorrection> correction{};
    std::vector<TellingReading> telling{}; // most bits first; none: not converged, or no answer at most draws
    SampleStatus status = SampleStatus::failed;
    std::vector<std::string> missing{}; // why it is not converged
    std::optional<ReducedProblem> reduced{};
    std::int64_t computed = 0, kept = 0; // runs of the full model: of this process, that were in the store
    std::int64_t computed_by_reduced_model = 0;
    double seconds = 0.0;

    bool failed() const { return status == SampleStatus::failed; }
    bool converged() const { return status == SampleStatus::converged; }
    std::string reason() const; // of not being converged
};

// Throws pave::Error for a study whose noise no sample can do without.
void check_noise_for_sample(const study::Study& study);

// Throws pave::Error for a study that cannot be fitted or does not state its noise. Nothing: interrupted.
std::optional<SampleResult> sample(Session& session, const study::Study& study, const SampleOptions& options);

// Draws that gather in places with next to nothing between them.
struct Mode {
    double centre = 0.0, share = 0.0; // the median, and the share of all weight
};
// On a scale from 0 to 1; one mode or more, from low to high.
std::vector<Mode> modes_of(std::span<const double> units, std::span<const double> weight);

// The findings of the draws, in sentences.
std::vector<std::string> findings(const SampleResult& result);

} // namespace explore::analysis
