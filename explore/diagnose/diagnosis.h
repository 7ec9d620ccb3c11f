// Which effect does the model lack? Everything that is computed to say so.
#pragma once

#include "diagnose/residual_tests.h"
#include "landscape/multistart.h"

namespace explore::diagnose {

// Readings that are left out together.
struct Fold {
    std::string name;
    std::vector<std::size_t> terms; // of the misfit
};

struct Diagnosis;

// What readings say of where a correction is: nothing, that the model errs more at one place than at another, or that
// it errs at some place.
enum class Says { nothing, between_places, at_places };

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
    // What is known of corrections (those of its location); without: all.
    std::function<Says(const Diagnosis& diagnosis)> says_where = {};
};

struct DiagnosisSettings {
    int explore = 64;   // points of the sample for the baseline
    int starts = 8;     // searches from them
    int bootstrap = 40; // fits of simulated data
};

// A fitted model and what the data say of it.
struct Judged {
    Model model;
    double chi2 = 0.0;
    int dof = 0;          // readings - directions that the parameters can follow
    double p_value = 1.0; // of chi2; 1 without stated noise
    double aicc = 0.0;
    PatternTest pattern;

    // Whether the size of this member, or of any, is where its range ends.
    bool ends_range(std::size_t member) const;
    bool ends_range() const;
};

// Akaike's criterion, up to a constant of the data. sum: of the squared residuals. In units of their noise where it is
// stated: chi2 + 2 k, for the optimism of chi2 is then 2 k exactly (Akaike 1973). Else the noise counts as one more
// parameter, with the correction for few data (Hurvich and Tsai 1989), infinite where the parameters are too many for
// it.
double aicc(double sum, std::size_t readings, std::size_t parameters, bool noise_is_stated);

struct Interval {
    double value = 0.0, low = 0.0, high = 0.0; // physical
};
// 95 % interval of a parameter within its range. unit, variance: its unit coordinate and the variance of that.
Interval interval_within(const problem::Axis& axis, double unit, double variance);
// The same of a fitted model, to first order.
Interval interval_of(const problem::Problem& problem, const Model& model, std::size_t axis, double variance);

// Another variant of an effect, which these readings do not tell from the one that explains most.
struct Alike {
    std::size_t candidate = 0;
    double behind = 0.0; // chi2 above that of the variant that explains most
    Interval size;
};

// What became of one effect.
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

// A set of effects that explains the data, and how much worse than the best it is.
struct Explanation {
    Judged fit;
    double behind = 0.0; // chi2 above that of the best explanation, with 2 ln(variants) for having chosen among them
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
    Eigen::MatrixXd covariance; // of the unit coordinates of the fit
    Target pull;                // what held the coefficients in it
};

enum class Verdict { adequate, cause_named, ambiguous, unexplained, located };
inline constexpr std::string_view verdict_names[] = {"adequate", "cause-named", "ambiguous", "unexplained", "located"};

struct Diagnosis {
    Verdict verdict = Verdict::adequate;
    std::string failed;    // why there is none
    double variance = 1.0; // of one residual
    Judged baseline;
    std::vector<GroupTest> groups; // at the baseline
    std::vector<Constancy> constancy;
    Screening screening;               // on the baseline
    std::vector<EffectResult> effects; // best explanation first, then by score
    double p_evidence = 1.0;           // family-wise, of the gain of the single effect that explains most
    double bartlett = 1.0; // mean gain in simulated data without the effect, in units of what linear theory expects
    int bootstrap = 0;     // simulated data that were fitted; how many of them gained as much:
    int bootstrap_above = 0;
    std::vector<Explanation> explanations; // that the data do not tell apart, best first
    std::vector<Explanation> nearest;      // where none explains the data: those that come nearest, best first
    bool leaves_more_than_noise = false;   // the best of them
    double noise_factor = 1.0; // by which the stated noise would have to be larger for what the answer's model leaves
    bool noise_is_overstated = false; // the baseline leaves less than the stated noise makes in one case of a hundred
    bool asks_for_correction = false; // beside what would be named, a correction explains more
    std::vector<std::string> causes;  // names, most probable first
    std::vector<Confounding> confounding; // of the effects with the best explanation's
    // Corrections: in place of names where the verdict is that, or such as explain the data nearly as well as a name.
    std::optional<Location> location;
    std::optional<Judged> extended; // the best explanation, or the corrected model
    std::optional<HeldOut> places, loads;

    bool is_located() const { return verdict == Verdict::located; }

    // What a further reading might tell apart.
    const std::vector<Explanation>& to_compare() const {
        return verdict == Verdict::unexplained ? nearest : explanations;
    }
};

// Nothing: interrupted.
std::optional<Diagnosis> diagnose(const DiagnosisTask& task, const DiagnosisSettings& settings);

} // namespace explore::diagnose
