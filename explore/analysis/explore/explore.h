// A study under someone's hands: what the model says at any point of the box, what other readings would change, and the
// landscape there. By the reduced model where the study has one, else by the full one; the full one confirms.
#pragma once

#include "analysis/common/curves.h"
#include "analysis/common/session.h"
#include "landscape/acceptance.h"

#include <atomic>
#include <mutex>

namespace explore::analysis {

// Measured readings that are taken to be others: index of the study's readings, value in the reading's unit. Their
// noise stays that of the study.
using ChangedReadings = std::vector<std::pair<std::size_t, double>>;

// The lowest point that a search found.
struct FoundMinimum {
    landscape::Minimum minimum;
    landscape::LocalAnalysis local;
    std::optional<landscape::Acceptance> acceptance; // none: no noise is stated, and nothing is left to estimate it
};

// Of two parameters: chi2 on a grid, the others as they are or fitted.
struct PairGrid {
    std::size_t x = 0, y = 0;
    std::vector<double> x_values, y_values; // physical, rising
    std::vector<double> chi2;               // of each node, x fastest; not a number: no answer
    double lowest = 0.0;                    // chi2 of the minimum that the limit counts from
    bool fitted = false;
};

struct ConfirmedPoint {
    problem::Evaluation evaluation; // of all loads, by the full model
    std::vector<Curve> curves;      // between the sensors
    double seconds = 0.0;
};

// May be called by several threads at once. Points are physical values in the order of the parameters; those out of the
// box are moved to its wall. All throw std::invalid_argument for another number of them, for a reading that is not
// measured, and for a value of one that no noise can be told of.
class Explorer {
public:
    // Builds or loads the reduced model and searches for the minima. Nothing: interrupted. Throws pave::Error for a
    // study without parameters or readings, std::runtime_error where no point of the box has an answer.
    static std::unique_ptr<Explorer> make(Session& session, study::Study study, double limit_percent);

    const study::Study& study() const { return study_; }
    const problem::ParameterSpace& space() const { return study_.space; }
    // Nothing: the full model answers.
    const std::optional<ReducedProblem>& reduced() const { return reduced_; }
    std::string why_full() const { return why_full_; }
    const std::vector<FoundMinimum>& minima() const { return minima_; }     // of the study's readings, best first
    const std::vector<Curve>& curves_of_minimum() const { return curves_; } // of the full model at the best
    double seconds_a_point() const { return seconds_a_point_; }             // of evaluate(), measured

    // Variance of a residual that chi2 is in units of: 1 where the noise is stated, contradicted or not; else that of
    // the best fit's residuals.
    double unit_variance() const {
        const auto& acceptance = minima_.front().acceptance;
        return acceptance && !acceptance->noise_is_stated ? acceptance->variance : 1.0;
    }
    double chi2(const problem::Evaluation& evaluation) const {
        return evaluation.misfit * evaluation.misfit / unit_variance();
    }
    // By how much chi2 may rise, in its own units: of noise that is contradicted as far as the noise is taken larger.
    // Nothing: no noise is known.
    std::optional<double> limit() const {
        const auto& acceptance = minima_.front().acceptance;
        return acceptance ? std::optional(acceptance->threshold * acceptance->variance / unit_variance())
                          : std::nullopt;
    }
    // In the standard deviations that chi2 is of, of every reading in the order of the study; not a number: not fitted.
    std::vector<double> residuals(const problem::Evaluation& evaluation, const ChangedReadings& changes);

    problem::Evaluation evaluate(const std::vector<double>& values, const ChangedReadings& changes);
    // The minimum that a search from there ends in. Nothing: interrupted, or no answer at the start.
    std::optional<FoundMinimum> fit(const std::vector<double>& values, const ChangedReadings& changes);

    // A later call of landscape() makes an earlier one give up. x < y; lines: of each parameter, from 2
    // to 101. Nothing: given up or interrupted.
    std::optional<PairGrid> landscape(std::size_t x, std::size_t y, const std::vector<double>& values,
                                      const ChangedReadings& changes, int lines, bool fitted);

    ConfirmedPoint confirm(const std::vector<double>& values, const ChangedReadings& changes);

private:
    Explorer(study::Study study, run::EngineSettings engine) : study_(std::move(study)), engine_(engine) {}
    bool search();
    FoundMinimum described(landscape::Minimum minimum, const problem::Problem& problem) const;
    std::vector<double> unit_of(const std::vector<double>& values) const;
    // The study's problem with these readings, its function that which answers here.
    std::shared_ptr<const problem::Problem> with(const ChangedReadings& changes);
    std::optional<FoundMinimum> fit_from(const std::vector<std::vector<double>>& starts,
                                         const problem::Problem& problem);
    std::optional<PairGrid> fitted_landscape(PairGrid grid, const std::vector<double>& unit,
                                             const problem::Problem& problem, int lines);

    study::Study study_;
    run::EngineSettings engine_;
    std::optional<ReducedProblem> reduced_;
    std::string why_full_;
    std::vector<FoundMinimum> minima_;
    std::vector<Curve> curves_;
    double seconds_a_point_ = 0.0;

    std::shared_ptr<const problem::Problem> problem_; // of the study's own readings
    std::mutex changed_mutex_;
    ChangedReadings changes_; // those of changed_
    std::shared_ptr<const problem::Problem> changed_;

    std::mutex point_mutex_; // one point at a time, beside searches
    std::unique_ptr<problem::ForwardFunction::Workspace> workspace_;
    std::mutex search_mutex_; // one search or landscape at a time
    std::mutex confirm_mutex_;
    std::atomic<std::uint64_t> newest_landscape_{0};
};

} // namespace explore::analysis
