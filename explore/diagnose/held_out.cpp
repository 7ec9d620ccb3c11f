#include "diagnose/held_out.h"

#include "run/progress.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace explore::diagnose {
namespace {

using Fits = std::vector<std::optional<Model>>; // of the folds

// All folds at once: what one of them is fitted to is another's business, the model is the same, so that their searches
// go in step.
class LeftOut {
public:
    LeftOut(const LeftOutTask& asked, const std::vector<const Fold*>& folds, int number)
        : task_(asked.task),
          d_(asked.d),
          best_(asked.extended.model),
          explored_(asked.explored),
          extended_(on_coarse(asked.task.bench, best_, number)),
          number_(number) {
        for (const Fold* fold : folds) {
            rest_.push_back(leaving_out(fold->terms, static_cast<std::size_t>(d_.baseline.model.residuals.size())));
            pulled_.push_back(rest_.back());
            pulled_.back().penalty = asked.pull.penalty;
            pulled_.back().centre = asked.pull.centre;
        }
    }

    // The baseline without these readings, from where it is with them and from the best of what was explored; nothing:
    // no answer.
    Fits before() {
        const Model& known = d_.baseline.model;
        const OnCoarse& base = d_.screening.base;
        const std::vector<std::vector<double>> there(rest_.size(), known.unit);
        Fits found = fit(known.members, there, rest_, base, {});
        // Without these readings another minimum may be lower.
        std::vector<std::vector<double>> nearest(explored_.empty() ? 0 : rest_.size());
        for (std::size_t f = 0; f < nearest.size(); ++f) {
            const auto sum = [&](const Explored& point) { return counted_sum(point.residuals, rest_[f]); };
            nearest[f] =
                std::min_element(explored_.begin(), explored_.end(), [&](const Explored& a, const Explored& b) {
                    return sum(a) < sum(b);
                })->unit;
        }
        keep_lower_of_each(found, fit(known.members, nearest, rest_, base, found));
        confirm(found, rest_, known);
        return found;
    }

    // The extended model, from where it is with them and from `before` with no effect and no correction.
    Fits after(const Fits& before) {
        std::vector<std::vector<double>> there(rest_.size());
        std::vector<std::vector<double>> none(rest_.size());
        for (std::size_t f = 0; f < rest_.size(); ++f) {
            if (!before[f]) {
                continue;
            }
            there[f] = best_.unit;
            none[f] = before[f]->unit;
            for (const std::size_t m : best_.members) {
                none[f].push_back(m < task_.candidates.size() ? task_.candidates[m].null : no_correction);
            }
        }
        Fits found = fit(best_.members, there, pulled_, extended_, {});
        keep_lower_of_each(found, fit(best_.members, none, pulled_, extended_, found));
        confirm(found, pulled_, best_);
        return found;
    }

private:
    // Numbers of the next stage.
    int next() {
        progress_.add(1, true);
        return number_ + static_cast<int>(rest_.size()) * stage_++;
    }

    // On the coarse mesh, of the folds that have a start. A search that leads to nothing lower than was found is given
    // up. Derivatives at the start; afterwards only where a step without them fails.
    Fits fit(const Members& members, const std::vector<std::vector<double>>& starts, const std::vector<Target>& targets,
             const OnCoarse& coarse, const Fits& found) {
        constexpr double lower = 0.1; // chi2
        const int first = next();
        std::vector<Start> all;
        for (std::size_t f = 0; f < starts.size(); ++f) {
            FitSettings settings =
                found.empty() ? for_residuals(&coarse.evaluation, d_.variance) : FitSettings{.secant_below = INFINITY};
            if (!found.empty() && found[f]) {
                settings.worth = found[f]->sum - lower * d_.variance;
            }
            settings.on_coarse = &coarse.shift;
            all.push_back({starts[f], &targets[f], settings});
        }
        return fit_in_step(task_.bench, members, first, all, d_.variance);
    }

    // Results of the coarse mesh, as the study's own has them; where the two part, fitted on from there on that
    // one by the derivatives of what is known with all readings.
    void confirm(Fits& found, const std::vector<Target>& targets, const Model& known) {
        const int first = next();
        const int further = next();
        std::vector<std::size_t> of;
        for (std::size_t f = 0; f < found.size(); ++f) {
            if (found[f]) {
                of.push_back(f);
            }
        }
        std::vector<problem::Evaluation> there(found.size());
        std::vector<Eigen::VectorXd> residuals(found.size());
        task_.bench.chains(known.members, first, of.size(),
                           [&](const problem::Problem& problem, std::size_t i, run::Chain& chain) {
                               const std::size_t f = of[i];
                               there[f] = chain.at(found[f]->unit, false);
                               if (there[f].converged()) {
                                   residuals[f] = problem.setting_apart(targets[f].left_out).residuals(there[f]);
                               }
                           });
        std::vector<Start> apart(found.size());
        for (const std::size_t f : of) {
            if (!there[f].converged()) {
                found[f].reset();
                continue;
            }
            constexpr double alike = 1.0; // chi2
            const double more = counted_sum(residuals[f], targets[f]) - counted_sum(found[f]->residuals, targets[f]);
            if (std::abs(more) > alike * d_.variance) {
                there[f].jacobian = known.evaluation.jacobian;
                apart[f] = {found[f]->unit, &targets[f], for_residuals(&there[f], d_.variance)};
            } else {
                found[f]->residuals = std::move(residuals[f]);
            }
        }
        Fits own = fit_in_step(task_.bench, known.members, further, apart, d_.variance);
        for (std::size_t f = 0; f < found.size(); ++f) {
            if (!apart[f].unit.empty()) {
                found[f] = std::move(own[f]);
            }
        }
    }
    static void keep_lower_of_each(Fits& best, Fits found) {
        for (std::size_t f = 0; f < found.size(); ++f) {
            keep_lower(best[f], std::move(found[f]));
        }
    }

    const DiagnosisTask& task_;
    const Diagnosis& d_;
    const Model& best_;
    const std::vector<Explored>& explored_;
    const OnCoarse extended_;
    const int number_;
    static constexpr int stages = 8;
    int stage_ = 0;
    run::Progress progress_{"held out", stages};
    std::vector<Target> rest_, pulled_; // of the folds: for the baseline, and with what holds the extended model's
};

// Root mean squares over the folds; nothing: no reading is left to predict.
std::optional<HeldOut> held_out(const std::vector<HeldOut::Item>& squares, const std::vector<std::size_t>& counts) {
    HeldOut held;
    for (std::size_t f = 0; f < squares.size(); ++f) {
        if (counts[f] > 0) {
            const auto n = static_cast<double>(counts[f]);
            held.folds.push_back({squares[f].name, std::sqrt(squares[f].before / n), std::sqrt(squares[f].after / n)});
            held.before += squares[f].before;
            held.after += squares[f].after;
            held.readings += counts[f];
        }
    }
    if (held.readings == 0) {
        return std::nullopt;
    }
    held.before = std::sqrt(held.before / static_cast<double>(held.readings));
    held.after = std::sqrt(held.after / static_cast<double>(held.readings));
    return held;
}

} // namespace

std::vector<std::optional<HeldOut>> predict_left_out(const LeftOutTask& asked,
                                                     const std::vector<std::vector<Fold>>& divisions, int number) {
    const DiagnosisTask& task = asked.task;
    std::set<std::size_t> wrong;
    for (const std::size_t c : asked.extended.model.members) {
        if (c < task.candidates.size() && task.candidates[c].reading) {
            wrong.insert(*task.candidates[c].reading);
        }
    }
    std::vector<const Fold*> folds;
    for (const auto& division : divisions) {
        std::transform(division.begin(), division.end(), std::back_inserter(folds), [](const Fold& f) { return &f; });
    }
    LeftOut left_out(asked, folds, number);
    const Fits before = left_out.before();
    const Fits after = left_out.after(before);
    std::vector<std::optional<HeldOut>> all;
    std::size_t f = 0;
    for (const auto& division : divisions) {
        std::vector<HeldOut::Item> squares;
        std::vector<std::size_t> counts(division.size(), 0);
        for (std::size_t k = 0; k < division.size(); ++k, ++f) {
            squares.push_back({division[k].name});
            for (const std::size_t i : after[f] ? division[k].terms : std::vector<std::size_t>()) {
                if (!wrong.contains(i) && !task.is_limit(i)) {
                    const auto row = static_cast<Eigen::Index>(i);
                    squares[k].before += std::pow(before[f]->residuals[row], 2) / asked.d.variance;
                    squares[k].after += std::pow(after[f]->residuals[row], 2) / asked.d.variance;
                    ++counts[k];
                }
            }
        }
        all.push_back(held_out(squares, counts));
    }
    return all;
}

} // namespace explore::diagnose
