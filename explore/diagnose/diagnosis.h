// Which effect does the model lack? Everything that is computed to say so.
//
// A diagnosis is a list of steps (diagnose/steps), each of which fits models and writes what it learnt into one ledger;
// the verdict is what `decide` makes of that (diagnose/decision.h).
#pragma once

#include "diagnose/decision.h"
#include "diagnose/judged.h"
#include "landscape/multistart.h"

namespace explore::diagnose {

// Readings that are left out together.
struct Fold {
    std::string name;
    std::vector<std::size_t> terms; // of the misfit
};

struct DiagnosisTask {
    Workbench& bench;
    std::vector<Candidate> candidates;
    std::vector<ReadingGroup> groups;
    std::vector<Fold> places; // of the sensors; every term in one
    std::vector<Fold> loads;
    std::uint64_t seed = 1;
    std::vector<Channel> channels{}; // of corrections
    // The sample by a quicker model of the baseline; empty: on the coarse mesh. Nothing: interrupted.
    std::function<std::optional<std::vector<problem::Evaluation>>(const search::Design& sample)> explore = {};
    // Where each term was read, for what errors may have in common; empty: not considered.
    std::vector<data::NoisePlace> noise_places{};
    // Of each term whether it is a limit (data::Censored): it counts in fits, and is no draw of the noise. Empty: none.
    std::vector<char> limits{};
    // Faults seen in the readings before any model, and mended in them.
    std::vector<hypotheses::Hypothesis> premises{};

    bool is_limit(std::size_t term) const { return term < limits.size() && limits[term] != 0; }
};

struct DiagnosisSettings {
    int explore = 64;   // points of the sample for the baseline
    int starts = 8;     // searches from them
    int bootstrap = 40; // fits of simulated data
};

// Another variant of an effect, which these readings do not tell from the one that explains most.
struct Alike {
    std::size_t candidate = 0;
    double behind = 0.0; // chi2 above that of the variant that explains most
    Interval size;
    Model model; // with this effect alone
};

// The result of one effect.
struct EffectResult {
    std::size_t candidate = 0; // its variant that explains most
    std::size_t variants = 0;  // that were compared
    std::string impossible;    // why it was not fitted; empty: it was
    double score = 0.0;        // of that variant
    double p_familywise = 1.0; // of the score
    double gain = 0.0;         // fall of chi2 in the full fit
    double delta_aicc = 0.0;
    std::optional<Judged> fit; // with this effect alone
    Interval size;
    std::vector<Alike> alike; // within what the data tell apart (95 %, one degree of freedom), nearest first
};

// A set of effects that explains the data, and how much less probable than the best it is.
struct Explanation {
    std::size_t row = 0; // of the ledger
    Judged fit;
    double behind = 0.0; // twice the logarithm of how much more probable the best one is
};

// How well two effects can be told apart by these readings.
struct Confounding {
    std::size_t a = 0, b = 0; // candidates
    double cosine = 0.0;      // of what they change in the residuals, beyond what the parameters follow
    double rate = 1.0;        // of the best possible decision between them, for an effect of the size found
};

struct HeldOut {
    double before = 0.0, after = 0.0; // root mean square of predicted residuals, standard deviations
    std::size_t readings = 0;
    struct Item {
        std::string name;
        double before = 0.0, after = 0.0;
    };
    std::vector<Item> folds;
};

// An effect of the catalogue beside a correction.
struct Likeness {
    std::size_t effect = 0; // among the results
    double share = 0.0; // of the squared change that the correction makes in the data, beyond what parameters follow
    bool leaves_noise = false; // alone, in place of the correction
};

// A correction that the data call for.
struct Correction {
    std::size_t channel = 0;
    double strength = 0.0;              // prior standard deviation of its coefficients
    double log_ratio = 0.0;             // of the marginal likelihoods with and without it, beside those before it
    double p_familywise = 1.0;          // of that
    std::vector<std::size_t> alike;     // channels in its place that explain nearly as much, best first
    std::vector<Likeness> explained_by; // largest share first
};

struct Location {
    std::vector<Correction> corrections; // in the order in which they were found
    Judged fit;                 // sum and chi2: with the penalties of the coefficients, whose expectation is dof
    int numbers = 0;            // coefficients, as far as the data set them free
    Eigen::MatrixXd covariance; // of the unit coordinates of the fit
    Target pull;                // what held the coefficients in it
};

struct Diagnosis {
    Ledger ledger;
    Decision decision;
    std::string failed;    // why there is none
    double variance = 1.0; // of one residual
    Judged baseline;
    std::vector<Model> minima;     // of the baseline, lowest first
    std::vector<GroupTest> groups; // at the baseline
    std::vector<Constancy> constancy;
    Screening screening;               // on the baseline
    std::vector<EffectResult> effects; // best explanation first, then by score
    double p_evidence = 1.0;           // family-wise, of the gain of the single effect that explains most
    double bartlett = 1.0; // mean gain in simulated data without the effect, in units of what linear theory expects
    int bootstrap = 0;     // simulated data that were fitted; how many of them gained as much:
    int bootstrap_above = 0;
    std::vector<Explanation> explanations; // the names of the decision, best first
    std::vector<Explanation> nearest;      // where there are none: those that come nearest, best first
    bool noise_is_overstated = false; // the baseline leaves less than the stated noise makes in one case of a hundred
    std::vector<Confounding> confounding; // of the effects with the best explanation's
    std::optional<Location> location;     // corrections that were found, whatever is made of them
    std::optional<Judged> extended;       // the model of the decision
    std::optional<HeldOut> places, loads; // by it
    // Of the baseline's unit coordinates under rows of the ledger whose errors have something in common: covariance.
    std::map<std::size_t, Eigen::MatrixXd> by_noise;

    // The covariance of the baseline's coordinates where it is right: under the noise of the decision.
    const Eigen::MatrixXd* covariance_by_noise() const {
        const auto at = verdict() == Verdict::adequate && !decision.as_stated && decision.noise
                            ? by_noise.find(*decision.noise)
                            : by_noise.end();
        return at == by_noise.end() ? nullptr : &at->second;
    }

    Verdict verdict() const { return decision.verdict; }
    bool is_located() const { return decision.is_located(); }
    // Whether the corrections are part of the answer, its rival, or what comes nearest.
    bool shows_location() const { return location && decision.correction; }
    // Whether the reported model is that of the corrections.
    bool is_corrected() const {
        return decision.model && ledger.rows()[*decision.model].hypothesis.kind == hypotheses::Kind::correction;
    }

    // Hypotheses that a further reading might tell apart.
    const std::vector<Explanation>& to_compare() const {
        return verdict() == Verdict::unexplained ? nearest : explanations;
    }
};

class Investigation;

// In two parts, for only who knows what a correction means can say which places it knows.
class Diagnoser {
public:
    // task, settings: to outlive this.
    Diagnoser(const DiagnosisTask& task, const DiagnosisSettings& settings);
    ~Diagnoser();

    // Fits everything. False: interrupted.
    bool find();
    // The results so far; a location is there if the decision may rest on it.
    const Diagnosis& found() const;
    // Decides. says: of the location, if there is one. False: interrupted.
    bool conclude(Says says);
    Diagnosis result();

private:
    std::unique_ptr<Investigation> investigation_;
};

// Both, where it is known beforehand what corrections say. Nothing: interrupted.
std::optional<Diagnosis> diagnose(const DiagnosisTask& task, const DiagnosisSettings& settings,
                                  Says says = Says::at_places);

} // namespace explore::diagnose
