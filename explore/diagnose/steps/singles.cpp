// One effect at a time.
#include "diagnose/steps/investigation.h"

#include "inference/quantiles.h"
#include "run/progress.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace explore::diagnose {

using Eigen::VectorXd;

namespace {

constexpr std::size_t scanned_of_singles = 30; // candidates computed at several sizes
// Few readings are bent far by the parameters: what the screening predicts of an effect is worth little there, and a
// fit costs little.
constexpr std::size_t few_readings = 20;

} // namespace

// The candidates that are worth a fit: of the effects that lead by what the screening predicts so many, those that
// lead by their score in any case (large effects bend, and what is predicted of them errs), and of each effect so
// many variants that are not far behind its first. all: none is left out for what the screening predicts of it.
std::vector<std::size_t> Investigation::worth_fitting(const Screening& screening, std::size_t effects, std::size_t each,
                                                      bool all) const {
    std::vector<std::size_t> order;
    for (std::size_t c = 0; c < screening.items.size(); ++c) {
        const Screened& item = screening.items[c];
        if (item.impossible.empty() && !item.identical && !item.starts.empty()) {
            order.push_back(c);
        }
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::abs(screening.items[a].score) > std::abs(screening.items[b].score);
    });
    constexpr std::size_t by_score = 4;
    std::map<std::string, std::size_t> scoring; // and its variant with the highest score
    for (std::size_t i = 0; i < order.size() && scoring.size() < by_score; ++i) {
        scoring.try_emplace(task_.candidates[order[i]].effect, order[i]);
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return screening.items[a].predicted < screening.items[b].predicted;
    });
    struct Taken {
        std::size_t count = 0;
        double predicted = 0.0; // of the first
    };
    std::map<std::string, Taken> taken;
    const double best = order.empty() ? 0.0 : screening.items[order[0]].predicted;
    std::erase_if(order, [&](std::size_t c) {
        const double predicted = screening.items[c].predicted;
        constexpr double hopeless = 50.0; // chi2 behind the best; the prediction errs, so some are taken anyway
        constexpr std::size_t anyway = 4; // effects
        const auto leader = scoring.find(task_.candidates[c].effect);
        const bool is_scoring = leader != scoring.end() && leader->second == c;
        if (!all && taken.size() >= anyway && predicted > best + hopeless * d_.variance && !is_scoring) {
            return true;
        }
        const auto [at, is_new] = taken.try_emplace(task_.candidates[c].effect);
        if (is_new) {
            at->second.predicted = predicted;
        }
        constexpr double far = 25.0; // chi2
        const bool is_behind = predicted > at->second.predicted + far * d_.variance;
        return !is_scoring && (taken.size() > effects || is_behind || ++at->second.count > each);
    });
    return order;
}

bool Investigation::fit_singles() {
    auto screening = screen(bench_, d_.baseline.model, task_.candidates, d_.variance, !noise_is_stated_, task_.seed,
                            scanned_of_singles, screen_number);
    if (!screening) {
        return false;
    }
    d_.screening = std::move(*screening);
    const bool all = rows() <= few_readings;
    constexpr std::size_t leading = 12;
    constexpr std::size_t variants_each = 2;
    const auto chosen = worth_fitting(d_.screening, all ? task_.candidates.size() : leading, variants_each, all);
    std::vector<std::optional<Model>> models(chosen.size());
    const Model* other = d_.minima.size() > 1 ? &d_.minima[1] : nullptr;
    run::Progress progress("fits", 2 * static_cast<std::int64_t>(chosen.size()));
    run::for_each_index(arena_, chosen.size(), [&](std::size_t i) {
        const Model& base = d_.baseline.model;
        const Screened& screened = d_.screening.items[chosen[i]];
        models[i] = fits_.added(base, other, screened, chosen[i], fit_number, INFINITY, false); // some stay
        const Candidate& candidate = task_.candidates[chosen[i]];
        if (all && !fits_.reaches(models[i], screened) && !candidate.reading && candidate.scaled.empty()) {
            models[i] =
                fits_.from_all_sides(base, screened, chosen[i], blind_number, std::move(models[i]), INFINITY, false);
        }
        progress.add(1, true);
    });
    double lowest = d_.baseline.model.sum;
    for (const auto& model : models) {
        lowest = model ? std::min(lowest, model->sum) : lowest;
    }
    run::for_each_index(arena_, chosen.size(), [&](std::size_t i) {
        // Those that gain nothing or are out of the question stay as the coarse mesh has them.
        constexpr double far = 25.0; // chi2
        constexpr double something = 2.0;
        if (models[i] &&
            models[i]->sum < std::min(lowest + far * d_.variance, d_.baseline.model.sum - something * d_.variance)) {
            models[i] = fits_.confirm(models[i], fit_number);
        }
        progress.add(1, true);
    });
    if (run::interrupted()) {
        return false;
    }
    collect_effects(chosen, models);
    return true;
}

void Investigation::collect_effects(const std::vector<std::size_t>& chosen, std::vector<std::optional<Model>>& models) {
    d_.effects.clear();
    std::map<std::string, std::size_t> index;
    for (std::size_t c = 0; c < task_.candidates.size(); ++c) {
        const auto [at, is_new] = index.try_emplace(task_.candidates[c].effect, d_.effects.size());
        if (is_new) {
            d_.effects.emplace_back();
            d_.effects.back().candidate = c;
            d_.effects.back().impossible = d_.screening.items[c].impossible;
        }
        EffectResult& effect = d_.effects[at->second];
        ++effect.variants;
        if (std::abs(d_.screening.items[c].score) > std::abs(d_.screening.items[effect.candidate].score)) {
            effect.candidate = c;
            effect.impossible = d_.screening.items[c].impossible;
        }
    }
    singles_.clear();
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        EffectResult& effect = d_.effects[index[task_.candidates[chosen[i]].effect]];
        if (models[i]) {
            singles_.emplace_back(chosen[i], *models[i]);
        }
        if (models[i] && (!effect.fit || models[i]->sum < effect.fit->model.sum)) {
            effect.candidate = chosen[i];
            effect.fit = judged(std::move(*models[i]));
        }
    }
    for (EffectResult& effect : d_.effects) {
        const Screened& screened = d_.screening.items[effect.candidate];
        effect.score = screened.score;
        effect.p_familywise = screened.p_familywise;
        if (effect.fit) {
            effect.impossible.clear();
        } else if (effect.impossible.empty()) {
            effect.impossible = "not among those that promise most";
        }
    }
    set_statistics();
}

void Investigation::take_single(EffectResult& effect, Model model) {
    effect.impossible.clear();
    singles_.emplace_back(effect.candidate, model);
    effect.fit = judged(std::move(model));
}

// The other variants of an effect that were fitted and are not rejected beside its best one.
std::vector<Alike> Investigation::alike_of(const EffectResult& effect) const {
    std::vector<Alike> list;
    for (const auto& [candidate, model] : singles_) {
        const double behind = (model.sum - effect.fit->model.sum) / d_.variance;
        if (candidate != effect.candidate && behind <= inference::chi2_95 &&
            task_.candidates[candidate].effect == task_.candidates[effect.candidate].effect) {
            const auto problem = bench_.problem(model.members);
            list.push_back(
                {candidate, behind, interval_of(*problem, model, problem->space.axes.size() - 1, d_.variance), model});
        }
    }
    std::stable_sort(list.begin(), list.end(), [](const Alike& a, const Alike& b) { return a.behind < b.behind; });
    return list;
}

// Everything that depends on the variance.
void Investigation::set_statistics() {
    if (!noise_is_stated_) { // the noise is that of the best model's residuals
        d_.variance = d_.baseline.model.sum / std::max(1, d_.baseline.dof);
        for (const EffectResult& effect : d_.effects) {
            if (effect.fit) {
                d_.variance = std::min(d_.variance, effect.fit->model.sum / std::max(1, effect.fit->dof));
            }
        }
        d_.variance = std::max(d_.variance, 1e-24);
    }
    judge_effects();
}

void Investigation::judge_effects() {
    d_.baseline = judged(std::move(d_.baseline.model));
    for (EffectResult& effect : d_.effects) {
        if (effect.fit) {
            effect.fit = judged(std::move(effect.fit->model));
            effect.gain = d_.baseline.chi2 - effect.fit->chi2;
            effect.delta_aicc = effect.fit->aicc - d_.baseline.aicc;
            effect.size = effect.fit->sizes[0];
            if (effect.gain < inference::chi2_95) { // no effect is accepted, too
                const auto problem = bench_.problem(effect.fit->model.members);
                const double none = problem->space.axes.back().physical(task_.candidates[effect.candidate].null);
                effect.size.low = std::min(effect.size.low, none);
                effect.size.high = std::max(effect.size.high, none);
            }
            effect.alike = alike_of(effect);
        }
    }
    std::stable_sort(d_.effects.begin(), d_.effects.end(), [&](const EffectResult& a, const EffectResult& b) {
        if (a.fit && b.fit) {
            return criterion(*a.fit) < criterion(*b.fit);
        }
        if (a.fit.has_value() != b.fit.has_value()) {
            return a.fit.has_value();
        }
        return std::abs(a.score) > std::abs(b.score);
    });
}

// Where no effect explains the data clearly better than the next, those that promised nothing are fitted too, as
// far as they get near those that lead: the baseline's parameters are bent to follow what is missing, and the
// screening may then not see it, or see it on the wrong side. Where none leaves noise, those that were fitted may have
// ended in a local minimum. False: interrupted.
bool Investigation::fit_untried() {
    constexpr double clearly = 6.0; // chi2
    const auto& e = d_.effects;
    const bool is_clear = noise_is_stated_ && !e.empty() && e[0].fit && e[0].fit->p_value >= level_noise &&
                          (e.size() < 2 || !e[1].fit || criterion(*e[1].fit) > criterion(*e[0].fit) + clearly);
    const bool is_stuck =
        noise_is_stated_ && rows() > few_readings && !e.empty() && e[0].fit && e[0].fit->p_value < level_noise;
    // Effects that read like the leader are tried in any case: large effects bend, and what is predicted of them errs.
    const inference::Nuisance nuisance = nuisance_of(d_.baseline.model);
    const VectorXd of_leader = is_clear ? direction_of(e[0], nuisance) : VectorXd();
    const auto is_like_leader = [&](const EffectResult& effect) {
        constexpr double alike = 0.5; // cosine
        const VectorXd own = direction_of(effect, nuisance);
        return of_leader.size() > 0 && own.size() > 0 && std::abs(own.dot(of_leader)) > alike;
    };
    std::vector<EffectResult*> untried;
    for (EffectResult& effect : d_.effects) {
        const Candidate& candidate = task_.candidates[effect.candidate];
        const bool has_sides = !candidate.reading && candidate.scaled.empty();
        const bool is_open = effect.fit ? !is_clear && is_stuck && has_sides && &effect != e.data()
                                        : d_.screening.items[effect.candidate].impossible.empty() &&
                                              (!is_clear || (has_sides && is_like_leader(effect)));
        if (is_open) {
            untried.push_back(&effect);
        }
    }
    const bool many_lead = e.size() >= beam_width && e[beam_width - 1].fit;
    const double worth = many_lead ? worth_beside(*e[beam_width - 1].fit) : INFINITY;
    std::vector<std::optional<Model>> models(untried.size());
    run::Progress progress("remaining fits", static_cast<std::int64_t>(untried.size()));
    run::for_each_index(arena_, untried.size(), [&](std::size_t i) {
        models[i] = fits_.blindly(d_.baseline.model, d_.screening, untried[i]->candidate, blind_number, worth);
        progress.add(1, true);
    });
    if (run::interrupted()) {
        return false;
    }
    for (std::size_t i = 0; i < untried.size(); ++i) {
        if (models[i] && (!untried[i]->fit || models[i]->sum < untried[i]->fit->model.sum)) {
            take_single(*untried[i], std::move(*models[i]));
        }
    }
    set_statistics();
    return true;
}

// The leading effects again, from points of the sample: a fit may have ended in a local minimum. False:
// interrupted.
bool Investigation::search_further() {
    std::vector<const Explored*> points;
    for (const Explored& point : explored_) {
        points.push_back(&point);
    }
    constexpr std::size_t leading = 6;
    constexpr std::size_t starts = 2;
    const std::size_t count = std::min(starts, points.size());
    std::partial_sort(
        points.begin(), points.begin() + static_cast<std::ptrdiff_t>(count), points.end(),
        [](const Explored* a, const Explored* b) { return a->residuals.squaredNorm() < b->residuals.squaredNorm(); });
    std::vector<EffectResult*> tried;
    for (EffectResult& effect : d_.effects) {
        if (effect.fit && tried.size() < leading) {
            tried.push_back(&effect);
        }
    }
    run::Progress progress("further fits", static_cast<std::int64_t>(tried.size()));
    run::for_each_index(arena_, tried.size(), [&](std::size_t i) {
        EffectResult& effect = *tried[i];
        const Members members = effect.fit->model.members;
        const Shift& shift = d_.screening.items[effect.candidate].shift;
        std::optional<Model> best;
        for (std::size_t s = 0; s < count; ++s) {
            std::vector<double> start = points[s]->unit;
            start.push_back(s == 0 ? effect.fit->model.unit.back() : task_.candidates[effect.candidate].typical);
            keep_lower(best, fits_.lower(members, further_number + static_cast<int>(s), start, shift, best,
                                         fits_.worth_confirming(effect.fit->model.sum), true));
        }
        std::optional<Model> lower = effect.fit->model;
        keep_lower(lower, fits_.confirm(best, further_number, lower->sum));
        effect.fit->model = std::move(*lower);
        progress.add(1, true);
    });
    if (run::interrupted()) {
        return false;
    }
    set_statistics();
    return true;
}

} // namespace explore::diagnose
