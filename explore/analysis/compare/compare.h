// The same data, each law in the same layer, or each study of several, fitted by the same search.
#pragma once

#include "analysis/common/session.h"
#include "landscape/uniqueness.h"
#include "material/law.h"

namespace explore::analysis {

struct CompareOptions {
    std::string layer{};             // empty: the one whose law depends on stress
    std::vector<std::string> laws{}; // empty: all
    landscape::UniquenessSettings settings{};
    bool evidence = false; // each posterior is sampled too
};

// How probable the data are under a law, whatever its parameters within their ranges and priors.
struct Evidence {
    double log = 0.0, error = 0.0; // natural logarithm of the density of the readings [SI], standard error
    double weight = 0.0;           // posterior probability among the laws, all alike before
    std::string missing{};         // why the sample has not converged; "": it has
};

// One law, or one study, and what the data say of it.
struct FittedLaw {
    const pave::material::Law* law = nullptr; // none: a study
    study::Study study;
    std::string failed{}; // why there is nothing more
    landscape::Uniqueness answer{};
    problem::Evaluation best{}; // of every response
    double misfit = 0.0;        // the study's own
    double chi2 = 0.0;          // sum of squared residuals, in units of the noise where it is stated
    int dof = 0;
    std::optional<double> p_value{};
    double aicc = 0.0;
    double weight = 0.0;                 // Akaike's, among the laws
    std::optional<double> by_place{};    // rms of readings left out place by place
    std::optional<double> study_holds{}; // rms of what the study holds out
    std::vector<double> group_rms{};
    std::optional<Evidence> evidence{};

    std::string name() const { return law != nullptr ? std::string(law->name()) : study.file; }
    std::string summary() const { return law != nullptr ? std::string(law->summary()) : study.title; }
};

struct CompareResult {
    study::Study study;
    std::string layer;           // whose laws they are; empty: they are studies
    std::vector<FittedLaw> laws; // best first
    bool same_noise = true;      // of studies: else chi2 and AICc have units of their own
    double seconds = 0.0;

    bool is_of_studies() const { return layer.empty(); }

    bool failed() const { return !laws[0].failed.empty(); }
    std::string reason() const {
        return std::string(is_of_studies() ? "no study" : "no law") +
               " has an answer; the first says: " + laws[0].failed;
    }
};

// Throws pave::Error for names that there are not, and laws that the study cannot have. Nothing: interrupted.
std::optional<CompareResult> compare(Session& session, const study::Study& study, const CompareOptions& options);

// Studies of the same readings. Throws pave::Error where the readings that they fit differ: by which, and how. The
// evidence is computed where every reading states its noise. Nothing: interrupted.
std::optional<CompareResult> compare_studies(Session& session, const std::vector<study::Study>& studies,
                                             const CompareOptions& options);

std::vector<std::string> findings(const CompareResult& result);

} // namespace explore::analysis
