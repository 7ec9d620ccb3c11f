// Everything that a diagnosis found out, in rows that are only ever added: each hypothesis with its fit, or why it was
// not tried, and what was learnt of it later. What follows from it: diagnose/decision.h.
#pragma once

#include "diagnose/workbench.h"
#include "hypotheses/evidence.h"
#include "hypotheses/hypothesis.h"

#include <optional>

namespace explore::diagnose {

// The residual of a fit.
struct Fit {
    Mesh mesh = Mesh::study;
    double chi2 = 0.0;         // in units of the noise as it is stated
    int dof = 0;               // readings - directions that the parameters can follow
    int numbers = 0;           // beside the study's parameters, as far as the data set them free
    double p_value = 1.0;      // of chi2; 1 without stated noise
    double pattern_chi2 = 0.0; // of smooth patterns in the residuals, expectation pattern_dof
    int pattern_dof = 0;
    double p_pattern = 1.0;
    bool at_end = false; // the interval of a size reaches the end of its range
};

struct Sized {
    std::string name;
    double value = 0.0, low = 0.0, high = 0.0; // 95 %
};

struct Row {
    hypotheses::Hypothesis hypothesis;
    std::vector<Sized> sizes{};
    std::string not_tried{}; // why; empty: `fit` is there
    Fit fit{};
    double log_prior = 0.0;    // probability beforehand
    double log_evidence = 0.0; // marginal likelihood, whatever the size of the noise; of Kind::none as it is stated
    double noise = 1.0;        // most probable size of the noise under it, where that is free
    std::optional<double> noise_by_data{}; // the same by the data alone; nothing: as noise
    int order = 1;              // to which its volume is known: 2, where directions that are open were looked along
    std::size_t model = 0;      // whoever adds the row: which of its models that is
    bool is_independent = true; // on the noise: errors of readings have nothing in common, whatever their size
    bool has_tails = false;     // on the noise: it makes single readings err far, as wrong readings do
    bool ends = false;          // on the noise: its size may be larger than any that was tried
    // Seen in the readings before any model (Kind::layout): what all the others rest on.
    bool is_premise = false;

    bool is_tried() const { return not_tried.empty() && !is_premise; }
    double log_weight() const { return log_prior + log_evidence; }
};

// A verdict on where a correction is: nothing, that the model errs more at one place than at another, or that
// it errs at some place.
enum class Says { nothing, between_places, at_places };

class Ledger {
public:
    // Readings that were left out of a fit, predicted with the hypothesis and without, in standard deviations.
    struct Predicted {
        std::string key;
        double before = 0.0, after = 0.0;
        bool by_study = false; // the study itself holds them out
    };
    struct Located {
        std::string key;
        Says says = Says::nothing;
    };
    // How often noise alone makes an effect gain as much, among all that were looked for.
    struct Chance {
        std::string key;
        double p = 1.0;
    };
    // How often the best possible decision between two is right, by these readings.
    struct Confounded {
        std::string a, b;
        double rate = 1.0;
    };
    // A correction that finds more beside a hypothesis.
    struct Beyond {
        std::string key;
        std::string subject; // of the correction, as in hypotheses::Term
        double p = 1.0;
    };

    // The most probable hypothesis by another premise (a section without a floor), where that was weighed.
    struct Elsewhere {
        std::string words;
        std::vector<hypotheses::Term> terms;
        double probability = 0.0; // beside the answer by these premises
    };

    Ledger() = default;
    explicit Ledger(bool noise_is_stated) : noise_is_stated_(noise_is_stated) {}

    void add(Row row) { rows_.push_back(std::move(row)); }
    void add(Predicted predicted) { predicted_.push_back(std::move(predicted)); }
    void add(Located located) { located_.push_back(std::move(located)); }
    void add(Chance chance) { chances_.push_back(std::move(chance)); }
    void add(Confounded confounded) { confounded_.push_back(std::move(confounded)); }
    void add(Beyond beyond) { beyond_.push_back(std::move(beyond)); }
    void add(Elsewhere elsewhere) { elsewhere_ = std::move(elsewhere); }
    // The chance that noise alone makes some effect look as promising as one did at the study's model.
    void add_score(double p_familywise) { score_ = p_familywise; }

    const std::vector<Row>& rows() const { return rows_; }
    bool noise_is_stated() const { return noise_is_stated_; }
    double score() const { return score_; }
    const std::optional<Elsewhere>& elsewhere() const { return elsewhere_; }
    // Of a hypothesis; the defaults where nothing was added.
    double chance(const std::string& key) const;
    Says says(const std::string& key) const;
    double rate(const std::string& a, const std::string& b) const;
    // Whether readings that were left out are predicted clearly worse with it than without: place by place and load by
    // load, by the sum of the logarithms of the errors, or those that the study itself holds out.
    bool is_predicted_worse(const std::string& key) const;
    // The least p of a correction beside it that is of none of these subjects.
    double beyond(const std::string& key, const std::vector<std::string>& subjects) const;

private:
    bool noise_is_stated_ = true;
    double score_ = 1.0;
    std::vector<Row> rows_;
    std::vector<Predicted> predicted_;
    std::vector<Located> located_;
    std::vector<Chance> chances_;
    std::vector<Confounded> confounded_;
    std::vector<Beyond> beyond_;
    std::optional<Elsewhere> elsewhere_;
};

// The row of a hypothesis that counts where it was fitted more than once: on the study's own mesh, the lowest.
std::vector<std::size_t> rows_that_count(const Ledger& ledger);

} // namespace explore::diagnose
