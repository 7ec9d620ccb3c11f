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
    LeftOut(const DiagnosisTask& task, const Diagnosis& d, const std::vector<Model>& explored, const Fold& fold)
        : task_(task),
          d_(d),
          explored_(explored),
          target_(leaving_out(fold.terms, static_cast<std::size_t>(d.baseline.model.residuals.size()))) {}

    // The baseline without these readings, from the best of what was explored; nothing: no answer.
    std::optional<Model> before(int number) const {
        const auto nearest = std::min_element(explored_.begin(), explored_.end(),
                                              [&](const Model& a, const Model& b) { return sum(a) < sum(b); });
        std::optional<Model> found = fit({}, number, nearest->unit, target_, for_residuals(nullptr, d_.variance));
        // Where that ended in a worse minimum than is known.
        const Model& known = d_.baseline.model;
        if (!found || found->sum > sum(known) + 0.1 * d_.variance) {
            keep_lower(found, fit({}, number + 1, known.unit, target_, for_residuals(&known.evaluation, d_.variance)));
        }
        return found;
    }

    // From there the extended model: from no effect, and from a typical one on the side that was found; corrections
    // from none.
    std::optional<Model> after(const Model& before, int number) const {
        const Model& best = d_.extended->model;
        std::optional<Model> found;
        const std::size_t own = before.unit.size();
        Target target = target_;
        if (d_.is_located()) {
            target.penalty = d_.location->pull.penalty;
            target.centre = d_.location->pull.centre;
        }
        for (int s = 0; s < (d_.is_located() ? 1 : 2); ++s) {
            std::vector<double> start = before.unit;
            for (std::size_t m = 0; m < best.members.size(); ++m) {
                if (best.members[m] >= task_.candidates.size()) {
                    start.push_back(no_correction);
                    continue;
                }
                const Candidate& candidate = task_.candidates[best.members[m]];
                const double reach = std::abs(candidate.typical - candidate.null);
                const double side = best.unit[own + m] > candidate.null ? 1.0 : -1.0;
                start.push_back(std::clamp(candidate.null + (s == 0 ? 0.0 : side * reach), 0.0, 1.0));
            }
            constexpr double lower = 0.1; // chi2: the same is the same without an effect
            FitSettings search = for_residuals(nullptr, d_.variance);
            search.worth = found ? found->sum - lower * d_.variance : INFINITY;
            keep_lower(found, fit(best.members, number + s, start, target, search));
        }
        return found;
    }

private:
    double sum(const Model& point) const { return counted_sum(point.residuals, target_); }
    std::optional<Model> fit(const Members& members, int number, const std::vector<double>& start, const Target& target,
                             const FitSettings& settings) const {
        return fit_from(task_.bench, members, number, start, d_.variance, target, settings);
    }

    const DiagnosisTask& task_;
    const Diagnosis& d_;
    const std::vector<Model>& explored_;
    Target target_;
};

} // namespace

std::optional<HeldOut> predict_left_out(const DiagnosisTask& task, const Diagnosis& d,
                                        const std::vector<Model>& explored, const std::vector<Fold>& folds,
                                        int number) {
    std::set<std::size_t> wrong;
    for (const std::size_t c : d.extended->model.members) {
        if (c < task.candidates.size() && task.candidates[c].reading) {
            wrong.insert(*task.candidates[c].reading);
        }
    }
    struct Squares {
        double before = 0.0, after = 0.0;
        std::size_t count = 0;
    };
    std::vector<Squares> squares(folds.size());
    tbb::task_arena arena(run::concurrency(task.bench.threads()));
    run::Progress progress("held out", static_cast<std::int64_t>(folds.size()));
    run::for_each_index(arena, folds.size(), [&](std::size_t f) {
        const LeftOut left_out(task, d, explored, folds[f]);
        const int own = number + 10 * static_cast<int>(f);
        const auto before = left_out.before(own);
        const auto after = before ? left_out.after(*before, own) : std::nullopt;
        for (const std::size_t i : after ? folds[f].terms : std::vector<std::size_t>()) {
            if (!wrong.contains(i)) {
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
