// Shared by the steps of a diagnosis.
#pragma once

#include "diagnose/candidate_fits.h"
#include "diagnose/diagnosis.h"
#include "diagnose/held_out.h"
#include "run/parallel.h"

#include <deque>
#include <set>

namespace explore::diagnose {

// Numbers of evaluations that are kept.
inline constexpr int screen_number = 100;
inline constexpr int fit_number = 200;
inline constexpr int further_number = 300;
inline constexpr int blind_number = 400;
inline constexpr int baseline_number = 500;
inline constexpr int minimum_number = 600;
inline constexpr int readings_number = 700;
inline constexpr int pair_number = 1000; // + 100 times the place in the beam
inline constexpr int fold_number = 5000;
inline constexpr int bootstrap_number = 20'000;
inline constexpr int open_number = 30'000;
inline constexpr int slope_number = 40'000; // + the corrections so far
inline constexpr int corrected_fit_number = 41'000;
inline constexpr int search_number = 10'000'000; // + the point of the sample

inline constexpr std::size_t beam_width = 4; // single effects that a second one is added to

// The state of a diagnosis and its steps, in the order in which they run. A step that returns a bool: false:
// interrupted.
class Investigation {
public:
    Investigation(const DiagnosisTask& task, const DiagnosisSettings& settings);

    bool find();
    bool conclude(Says says);
    Diagnosis& diagnosis() { return d_; }

private:
    // steps/baseline.cpp: the study's model
    bool fit_baseline();
    bool improve_baseline(bool& better);
    void examine_baseline();
    // steps/singles.cpp: one effect
    bool fit_singles();
    bool fit_untried();
    bool search_further();
    // steps/readings.cpp: several wrong readings
    bool fit_wrong_readings();
    // steps/pairs.cpp: two effects
    bool fit_two_effects();
    // steps/record.cpp: what was found, into the ledger
    void record_noise();
    std::vector<Alike> other_instruments(const EffectResult& effect) const;
    void record_singles();
    bool record_all();
    void record(const Judged& fit, hypotheses::Kind kind, int order = 1);
    bool weigh_chances();
    void weigh_confounding();
    bool settle();
    bool look_along_open_directions();
    // steps/corrections.cpp
    bool locate();
    void record_location();
    // steps/answer.cpp
    bool hold_out();
    void take_decision();

    std::size_t rows() const { return static_cast<std::size_t>(d_.baseline.model.residuals.size()); }
    inference::Nuisance nuisance_of(const Model& model) const { return judge_.nuisance_of(model, d_.variance); }
    Judged judged(Model model) const { return judge_.judge(std::move(model), d_.variance); }
    // Whether what a model leaves speaks against it.
    bool is_contradicted(const Judged& j) const;
    // Chi2 with the price of having chosen the best of several variants.
    double criterion(const Judged& j) const;
    std::size_t variants_of(std::size_t candidate) const;
    // The sum of squares below which a model stands beside this one among the explanations, or nearly so.
    double worth_beside(const Judged& j) const { return (criterion(j) + 2.0 * margin) * d_.variance; }
    std::optional<Model> fit_from(const Members& members, int number, const std::vector<double>& start,
                                  const Target& target = {}, const FitSettings& settings = {});
    double variance_of(double sum) const;
    void set_baseline(Model model);
    void fit_leading_minima(const search::Design& design, const landscape::MultistartResult& coarse, double distance);
    void fit_minima(const std::vector<std::vector<double>>& starts, int number, double worth);
    std::vector<std::size_t> worth_fitting(const Screening& screening, std::size_t effects, std::size_t each,
                                           bool all = false) const;
    void collect_effects(const std::vector<std::size_t>& chosen, std::vector<std::optional<Model>>& models);
    void take_single(EffectResult& effect, Model model);
    std::vector<Alike> alike_of(const EffectResult& effect) const;
    // Everything that depends on the variance.
    void set_statistics();
    void judge_effects(); // the same by the variance as it is
    std::optional<Screening> screen_seconds(const Model& base, std::size_t place, std::size_t scanned);
    bool fit_pairs(const std::vector<const Judged*>& beam, const Screening& of_first, std::vector<Judged>& pairs);
    template <class Fit>
    bool fit_jobs(const char* name, std::size_t count, std::vector<Judged>& pairs, const Fit& fit);
    bool fit_alone(const Members& members);
    hypotheses::Term term_of(std::size_t candidate) const;
    // Of the hypothesis that one candidate makes.
    hypotheses::Kind kind_of(std::size_t candidate) const;
    hypotheses::Counts counts() const;
    Eigen::VectorXd direction_of(const EffectResult& effect, const inference::Nuisance& nuisance) const;
    std::vector<const Judged*> fitted_singles() const;
    std::string key_of(const Judged& fit, hypotheses::Kind kind) const;
    hypotheses::Hypothesis hypothesis_of(const Judged& fit, hypotheses::Kind kind) const;

    const DiagnosisTask& task_;
    Workbench& bench_;
    const DiagnosisSettings& settings_;
    Diagnosis d_;
    Judge judge_;
    bool noise_is_stated_; // residuals are then in units of it
    tbb::task_arena arena_;
    CandidateFits fits_;
    std::vector<Explored> explored_;
    std::vector<std::pair<std::size_t, Model>> singles_; // every fit of one effect, by its candidate
    std::deque<Judged> models_;                          // of rows of the ledger; they stay where they are
    std::set<std::size_t> looked_;                       // of these: whose open directions were looked along
    std::vector<Judged> pairs_, wrong_readings_;
    int attempts_ = 0;
};

} // namespace explore::diagnose
