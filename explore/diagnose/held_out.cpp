#include "diagnose/held_out.h"

#include "run/parallel.h"
#include "run/progress.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace explore::diagnose {
namespace {

class LeftOut {
public:
    LeftOut(const LeftOutTask& asked, const OnCoarse& extended, const Fold& fold)
        : task_(asked.task),
          d_(asked.d),
          best_(asked.extended.model),
          pull_(asked.pull),
          explored_(asked.explored),
          extended_(extended),
          target_(leaving_out(fold.terms, static_cast<std::size_t>(d_.baseline.model.residuals.size()))) {}

    // The baseline without these readings, from where it is with them and from the best of what was explored; nothing:
    // no answer.
    std::optional<Model> before(int number) const {
        const Model& known = d_.baseline.model;
        const OnCoarse& base = d_.screening.base;
        std::optional<Model> found =
            fit({}, number, known.unit, target_, for_residuals(&base.evaluation, d_.variance), base.shift);
        // Without these readings another minimum may be lower.
        const auto nearest = std::min_element(explored_.begin(), explored_.end(),
                                              [&](const Explored& a, const Explored& b) { return sum(a) < sum(b); });
        if (nearest != explored_.end()) {
            keep_lower(found, fit({}, number + 1, nearest->unit, target_, below(found), base.shift));
        }
        return confirmed(std::move(found), number, target_, known);
    }

    // The extended model, from where it is with them and from `before` with no effect and no correction.
    std::optional<Model> after(const Model& before, int number) const {
        Target target = target_;
        target.penalty = pull_.penalty;
        target.centre = pull_.centre;
        std::optional<Model> found = fit(best_.members, number, best_.unit, target,
                                         for_residuals(&extended_.evaluation, d_.variance), extended_.shift);
        std::vector<double> none = before.unit;
        for (const std::size_t m : best_.members) {
            none.push_back(m < task_.candidates.size() ? task_.candidates[m].null : no_correction);
        }
        keep_lower(found, fit(best_.members, number + 1, none, target, below(found), extended_.shift));
        return confirmed(std::move(found), number, target, best_);
    }

private:
    // A search that is given up where it leads to nothing lower.
    FitSettings below(const std::optional<Model>& found) const {
        constexpr double lower = 0.1; // chi2
        // Derivatives at the start; afterwards only where a step without them fails.
        return {.secant_below = INFINITY, .worth = found ? found->sum - lower * d_.variance : INFINITY};
    }
    // Results of the coarse mesh, as the study's own has them; where the two part, fitted on from there on that
    // one by the derivatives of what is known with all readings.
    std::optional<Model> confirmed(std::optional<Model> found, int number, const Target& target,
                                   const Model& known) const {
        if (!found) {
            return found;
        }
        problem::Evaluation there;
        Eigen::VectorXd residuals;
        task_.bench.chain(found->members, number, [&](const problem::Problem& problem, run::Chain& chain) {
            there = chain.at(found->unit, false);
            if (there.converged()) {
                residuals = problem.setting_apart(target.left_out).residuals(there);
            }
        });
        if (!there.converged()) {
            return std::nullopt;
        }
        const double apart = counted_sum(residuals, target) - counted_sum(found->residuals, target);
        constexpr double alike = 1.0; // chi2
        if (std::abs(apart) > alike * d_.variance) {
            there.jacobian = known.evaluation.jacobian;
            return fit_from(task_.bench, found->members, number + 1, found->unit, d_.variance, target,
                            for_residuals(&there, d_.variance));
        }
        found->residuals = std::move(residuals);
        return found;
    }
    double sum(const Explored& point) const { return counted_sum(point.residuals, target_); }
    std::optional<Model> fit(const Members& members, int number, const std::vector<double>& start, const Target& target,
                             FitSettings settings, const Shift& shift) const {
        settings.on_coarse = &shift;
        return fit_from(task_.bench, members, number, start, d_.variance, target, settings);
    }

    const DiagnosisTask& task_;
    const Diagnosis& d_;
    const Model& best_;
    const Target& pull_;
    const std::vector<Explored>& explored_;
    const OnCoarse& extended_;
    Target target_;
};

} // namespace

std::optional<HeldOut> predict_left_out(const LeftOutTask& asked, const std::vector<Fold>& folds, int number) {
    const DiagnosisTask& task = asked.task;
    const Diagnosis& d = asked.d;
    std::set<std::size_t> wrong;
    for (const std::size_t c : asked.extended.model.members) {
        if (c < task.candidates.size() && task.candidates[c].reading) {
            wrong.insert(*task.candidates[c].reading);
        }
    }
    struct Squares {
        double before = 0.0, after = 0.0;
        std::size_t count = 0;
    };
    const OnCoarse extended = on_coarse(task.bench, asked.extended.model, number);
    std::vector<Squares> squares(folds.size());
    tbb::task_arena arena(run::concurrency(task.bench.threads()));
    run::Progress progress("held out", static_cast<std::int64_t>(folds.size()));
    run::for_each_index(arena, folds.size(), [&](std::size_t f) {
        const LeftOut left_out(asked, extended, folds[f]);
        const int own = number + 10 * static_cast<int>(f);
        const auto before = left_out.before(own);
        const auto after = before ? left_out.after(*before, own) : std::nullopt;
        for (const std::size_t i : after ? folds[f].terms : std::vector<std::size_t>()) {
            if (!wrong.contains(i) && !task.is_limit(i)) {
                const auto row = static_cast<Eigen::Index>(i);
                squares[f].before += std::pow(before->residuals[row], 2) / d.variance;
                squares[f].after += std::pow(after->residuals[row], 2) / d.variance;
                ++squares[f].count;
            }
        }
        progress.add(1, true);
    });
    HeldOut held;
    for (std::size_t f = 0; f < folds.size(); ++f) {
        if (squares[f].count > 0) {
            const auto n = static_cast<double>(squares[f].count);
            held.folds.push_back({folds[f].name, std::sqrt(squares[f].before / n), std::sqrt(squares[f].after / n)});
            held.before += squares[f].before;
            held.after += squares[f].after;
            held.readings += squares[f].count;
        }
    }
    if (held.readings == 0) {
        return std::nullopt;
    }
    held.before = std::sqrt(held.before / static_cast<double>(held.readings));
    held.after = std::sqrt(held.after / static_cast<double>(held.readings));
    return held;
}

} // namespace explore::diagnose
