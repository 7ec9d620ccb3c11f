// Diagnosis: the effect that the model lacks, the extended model, the gain.
#pragma once

#include "analysis/common/candidate_readings.h"
#include "analysis/common/data_faults.h"
#include "analysis/common/layout.h"
#include "analysis/common/load_steps.h"
#include "analysis/common/mesh_error.h"
#include "analysis/common/output_ranges.h"
#include "analysis/common/session.h"
#include "analysis/diagnose/located.h"
#include "study/variants.h"

namespace explore::analysis {

struct DiagnoseOptions {
    ModelOptions model{};
    std::vector<std::string> without{}; // effects that are known not to be there
    diagnose::DiagnosisSettings settings{};
};

// A model of the diagnosis with everything a report asks of it.
struct DiagnosedModel {
    study::Study study; // with the effects, their sizes free
    problem::Evaluation evaluation;
    double misfit = 0.0;                        // the study's own
    std::vector<diagnose::Interval> parameters; // the effects' sizes last
    std::optional<double> held_out_rms;         // of the readings the study holds out, standard deviations
};

// One reading that would separate what the data leave ambiguous.
struct SeparatingReading {
    data::Reading reading;                 // its noise: assumed
    bool again = false;                    // the study has it: another instrument takes it once more
    std::vector<std::size_t> explanations; // of Diagnosis::to_compare()
    std::vector<double> values;            // predicted by each of them, in the reading's unit
    double power = 0.0;    // the rate of the right decision between the best explanation and its closest rival
    double rate_now = 0.0; // the same with the present readings

    std::string words() const { return reading.words() + (again ? ", once more by another instrument" : ""); }
};

// Taken for granted by an answer, beside the study: faults of its readings, mended, and that it has no floor.
struct Premises {
    std::vector<data::BowlFault> faults{};
    bool no_floor = false;
};

struct DiagnoseResult {
    study::Study study; // with its readings mended, and without a floor where it has none by the premises
    Premises premises{};
    bool is_floor_weighed = false;     // whether the study without a floor was diagnosed, too
    std::vector<Rounding> roundings{}; // added to their noise
    bool is_otherwise_layered = false; // fit and unique compute it by the layered engine
    DiagnoseOptions options;
    std::vector<study::Variant> variants; // of effects, in the order of the candidates
    std::vector<diagnose::Candidate> candidates;
    std::vector<pave::pavement::Correction> corrections; // one each of the channels
    std::vector<diagnose::Channel> channels;
    Layout layout;
    diagnose::Diagnosis diagnosis;
    std::optional<DiagnosedModel> before;      // none: failed
    std::optional<DiagnosedModel> after;       // with the best explanation, or corrected
    std::optional<MeshError> mesh;             // of the extended model where there is one, else of the study's
    std::optional<PathError> path{};           // of the same
    std::vector<std::vector<double>> minima{}; // of an adequate model, as good as the reported one: unit coordinates
    std::vector<OutputUncertainty> outputs;    // of the named model where a cause is named, else of the study's
    std::vector<LocatedCorrection> located;
    std::vector<SeparatingReading> next;
    std::vector<TellingReading> telling;         // of the corrections, where they stand; most bits first
    std::vector<std::optional<double>> held_out; // of each explanation: see DiagnosedModel
    std::optional<ReducedProblem> reduced;
    run::Tally tally;
    double seconds = 0.0;

    bool failed() const { return !diagnosis.failed.empty(); }
    // Whether there is an extended model that explains the data.
    bool is_extended() const { return after && diagnosis.verdict() != diagnose::Verdict::unexplained; }
    // The study file of the extended model, with data files found from `folder`; is_extended().
    std::string extended_study(const std::string& folder) const;
};

// The study as diagnose computes it: by finite elements, where layers are linear too. Most effects are beyond the
// layered engine, and models are compared by one engine.
study::Study as_diagnosed(study::Study study);

// Throws pave::Error for a study that cannot be fitted and effects that there are not. Nothing: interrupted.
std::optional<DiagnoseResult> diagnose(Session& session, const study::Study& study, const DiagnoseOptions& options);

// Residuals in standard deviations, one a reading in the order of the data files; those not fitted are not numbers.
std::vector<double> residuals_of(const DiagnoseResult& result, const diagnose::Model& model);

// The verdict and its reasons, in sentences.
std::vector<std::string> findings(const DiagnoseResult& result);

// "sensor-gain (fwd, deflection) with outlier (...)"
std::string members_words(const std::vector<diagnose::Candidate>& candidates, const diagnose::Members& members);
// "95 %", "99.5 %", "0.03 %"
std::string percent(double share);

} // namespace explore::analysis
