#include "diagnose/diagnosis.h"

#include "diagnose/candidate_fits.h"
#include "diagnose/held_out.h"
#include "diagnose/location.h"
#include "diagnose/simulated_data.h"
#include "run/parallel.h"
#include "run/progress.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <set>

namespace explore::diagnose {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A model is contradicted when a test of it falls below its level: 2 % of sound models, at most. An extended model is
// named where what it leaves is noise at level_noise: more could be noise that was stated too small. Below
// level_explained it is no explanation, only what comes nearest; the pattern of the residuals alone says so at
// level_rejected.
constexpr double level_chi2 = 0.005;
constexpr double level_pattern = 0.005;
constexpr double level_family = 0.01;
constexpr double level_explained = 0.005;
constexpr double level_overstated = 0.01;
constexpr double level_rejected = 0.0005;
// Below this the fit may be a local minimum: it is searched for another.
constexpr double level_doubtful = 0.05;
// A cause is named when so much evidence is due to chance as rarely as level_evidence, and the next explanation fits
// this much worse: whatever the distance between two explanations, the true one falls so far behind in less than 1 % of
// cases, Phi(-sqrt(margin)).
constexpr double margin = 6.0;
constexpr double least_rate = 0.95; // of telling two effects apart
constexpr std::size_t scanned = 30; // candidates computed at several sizes
constexpr std::size_t scanned_of_pairs = 12;
constexpr std::size_t beam_width = 4; // single effects that a second one is added to

// Numbers of evaluations that are kept.
constexpr int screen_number = 100;
constexpr int fit_number = 200;
constexpr int pair_number = 1000; // + 100 times the place in the beam
constexpr int further_number = 300;
constexpr int blind_number = 400;
constexpr int baseline_number = 500;
constexpr int minimum_number = 600;
constexpr int fold_number = 5000;
constexpr int bootstrap_number = 20'000;
constexpr int search_number = 10'000'000; // + the point of the sample

class Diagnostician {
public:
    Diagnostician(const DiagnosisTask& task, const DiagnosisSettings& settings)
        : task_(task),
          bench_(task.bench),
          settings_(settings),
          noise_is_stated_(task.bench.problem({})->noise_is_stated()),
          arena_(run::concurrency(task.bench.threads())),
          fits_(task.bench, task_.candidates, d_.variance) {}

    // False: interrupted.
    bool run() {
        if (!fit_baseline()) {
            return false;
        }
        if (!d_.failed.empty()) {
            return true;
        }
        constexpr int baselines = 3;
        bool better = true;
        for (int attempt = 0; better && attempt < baselines; ++attempt) {
            if (!fit_singles()) {
                return false;
            }
            better = false;
            if (attempt + 1 < baselines && !improve_baseline(better)) {
                return false;
            }
        }
        examine_baseline();
        d_.noise_factor = noise_factor_of(d_.baseline);
        d_.noise_is_overstated = noise_is_stated_ && d_.baseline.dof > 0 &&
                                 gsl_cdf_chisq_P(d_.baseline.chi2, d_.baseline.dof) < level_overstated;
        if (!contradicted(d_.baseline, d_.screening.p_familywise)) {
            d_.verdict = Verdict::adequate;
            return true;
        }
        return fit_untried() && explain() && weigh_evidence() && decide() && locate(task_, d_) && hold_out();
    }

    Diagnosis result() { return std::move(d_); }

private:
    std::size_t rows() const { return static_cast<std::size_t>(d_.baseline.model.residuals.size()); }
    Mimicry mimicry_of(const Model& model) {
        const double noise = std::sqrt(d_.variance);
        return {bench_.problem(model.members)->residual_jacobian(model.evaluation) / noise, model.unit,
                model.residuals / noise};
    }

    Judged judge(Model model) {
        Judged j;
        const Mimicry mimicry = mimicry_of(model);
        j.chi2 = model.sum / d_.variance;
        j.dof = static_cast<int>(model.residuals.size()) - mimicry.rank();
        if (noise_is_stated_ && j.dof > 0) {
            j.p_value = gsl_cdf_chisq_Q(j.chi2, j.dof);
        }
        j.aicc = aicc(model.sum, static_cast<std::size_t>(model.residuals.size()), model.unit.size(), noise_is_stated_);
        j.pattern = test_pattern(model.residuals / std::sqrt(d_.variance), mimicry, task_.groups);
        j.model = std::move(model);
        return j;
    }

    bool contradicted(const Judged& j, double p_familywise) const {
        const bool by_noise = noise_is_stated_ && (j.p_value < level_chi2 || j.pattern.p_value < level_pattern);
        return by_noise || p_familywise < level_family;
    }

    bool rejected(const Judged& j) const {
        return noise_is_stated_ && (j.p_value < level_explained || j.pattern.p_value < level_rejected);
    }

    // By how much the stated noise would have to be larger for chi2 of this model to be what it is expected to be; 1
    // where noise as stated explains it.
    double noise_factor_of(const Judged& j) const {
        return noise_is_stated_ && j.dof > 0 && j.p_value < level_noise ? std::sqrt(j.chi2 / j.dof) : 1.0;
    }

    // Chi2 with the price of having chosen the best of several variants.
    double criterion(const Judged& j) const {
        double sum = j.chi2;
        for (const std::size_t c : j.model.members) {
            const auto same = std::count_if(task_.candidates.begin(), task_.candidates.end(), [&](const auto& other) {
                return other.effect == task_.candidates[c].effect;
            });
            sum += 2.0 * std::log(static_cast<double>(same));
        }
        return sum;
    }

    bool fit_baseline() {
        const auto baseline = bench_.problem({});
        const problem::Problem& problem = *baseline;
        const search::Design design = search::sobol(problem.space, settings_.explore, task_.seed);
        landscape::MultistartSettings multistart;
        multistart.starts = settings_.starts;
        multistart.search.enough = close_enough;
        multistart.first_kept = search_number;
        const auto search_all = [&] {
            return bench_.use({}, Mesh::coarse, [&](const problem::Problem& own, run::Engine& engine) {
                if (!task_.explore) {
                    return landscape::multistart(engine, own, design, multistart);
                }
                auto explored = task_.explore(design);
                return explored ? landscape::refine(engine, own, design, std::move(*explored), {}, multistart)
                                : std::nullopt;
            });
        };
        std::optional<landscape::MultistartResult> result;
        while (minima_.empty()) {
            result = search_all();
            if (!result) {
                return false;
            }
            if (!result->minima.empty()) {
                fit_leading_minima(design, *result, multistart.start_distance);
            }
            if (run::interrupted()) {
                return false;
            }
            if (minima_.empty() && !bench_.has_coarse()) {
                d_.failed = run::why_no_minimum(problem, result->explored);
                return true;
            }
            if (minima_.empty()) {
                bench_.give_up_coarse();
            }
        }
        for (std::size_t i = 0; i < result->explored.size(); ++i) {
            if (result->explored[i].converged()) {
                explored_.push_back({design.points[i], problem.residuals(result->explored[i])});
            }
        }
        set_baseline(minima_[0]);
        return true;
    }

    // The leading minima of the coarse mesh on the study's own, and whether points of the sample lead lower there.
    void fit_leading_minima(const search::Design& design, const landscape::MultistartResult& coarse, double distance) {
        constexpr std::size_t leading = 3;
        constexpr int from_sample = 2;
        constexpr double lower = 0.5; // chi2
        d_.variance = variance_of(std::pow(coarse.minima[0].evaluation.misfit, 2));
        std::vector<std::vector<double>> starts;
        for (std::size_t m = 0; m < std::min(leading, coarse.minima.size()); ++m) {
            starts.push_back(coarse.minima[m].unit);
        }
        fit_minima(starts, minimum_number, INFINITY);
        starts.clear();
        for (const std::size_t i : run::distinct_starts(design, coarse.explored, from_sample, distance)) {
            starts.push_back(design.points[i]);
        }
        fit_minima(starts, minimum_number + static_cast<int>(leading),
                   minima_.empty() ? INFINITY : minima_[0].sum - lower * d_.variance);
    }

    // Adds to the minima of the baseline what searches from these points find.
    void fit_minima(const std::vector<std::vector<double>>& starts, int number, double worth) {
        std::vector<std::optional<Model>> found(starts.size());
        run::for_each_index(arena_, starts.size(), [&](std::size_t s) {
            found[s] = fit_from({}, number + static_cast<int>(s), starts[s], {}, {.worth = worth});
        });
        for (auto& model : found) {
            if (model) {
                minima_.push_back(std::move(*model));
            }
        }
        std::stable_sort(minima_.begin(), minima_.end(), [](const Model& a, const Model& b) { return a.sum < b.sum; });
    }

    // Of a residual, where so much is left of all of them.
    double variance_of(double sum) const {
        const auto baseline = bench_.problem({});
        const double dof = static_cast<double>(baseline->rows()) - static_cast<double>(baseline->space.axes.size());
        return noise_is_stated_ ? 1.0 : std::max(sum / std::max(1.0, dof), 1e-24);
    }

    void set_baseline(Model model) {
        d_.variance = variance_of(model.sum);
        d_.baseline = judge(std::move(model));
    }

    std::optional<Model> fit_from(const Members& members, int number, const std::vector<double>& start,
                                  const Target& target = {}, const FitSettings& settings = {}) {
        return diagnose::fit_from(bench_, members, number, start, d_.variance, target, settings);
    }

    // What a model has to get below to stand beside this one among the explanations, and more: a sum of squares.
    double worth_beside(const Judged& j) const { return (criterion(j) + 2.0 * margin) * d_.variance; }

    // Where no effect explains the data clearly better than the next, those that promised nothing are fitted too, as
    // far as they get near those that lead: the baseline's parameters are bent to follow what is missing, and the
    // screening may then not see it. False: interrupted.
    bool fit_untried() {
        constexpr double clearly = 6.0; // chi2
        const auto& e = d_.effects;
        const bool is_clear = noise_is_stated_ && !e.empty() && e[0].fit && e[0].fit->p_value >= level_noise &&
                              (e.size() < 2 || !e[1].fit || criterion(*e[1].fit) > criterion(*e[0].fit) + clearly);
        std::vector<EffectResult*> untried;
        for (EffectResult& effect : d_.effects) {
            if (!is_clear && !effect.fit && d_.screening.items[effect.candidate].impossible.empty()) {
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
            if (models[i]) {
                take_single(*untried[i], std::move(*models[i]));
            }
        }
        set_statistics();
        return true;
    }

    void take_single(EffectResult& effect, Model model) {
        effect.impossible.clear();
        singles_.emplace_back(effect.candidate, model);
        effect.fit = judge(std::move(model));
    }

    // The candidates that are worth a fit: of the effects that lead by what the screening predicts so many, those that
    // lead by their score in any case (large effects bend, and what is predicted of them errs), and of each effect so
    // many variants that are not far behind its first. all: none is left out for what the screening predicts of it.
    std::vector<std::size_t> worth_fitting(const Screening& screening, std::size_t effects, std::size_t each,
                                           bool all = false) const {
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

    bool fit_singles() {
        auto screening = screen(bench_, d_.baseline.model, task_.candidates, d_.variance, !noise_is_stated_, task_.seed,
                                scanned, screen_number);
        if (!screening) {
            return false;
        }
        d_.screening = std::move(*screening);
        // Few readings are bent far by the parameters: what the screening predicts of an effect is worth little there,
        // and a fit costs little.
        constexpr std::size_t few = 20;
        const bool all = rows() <= few;
        constexpr std::size_t leading = 12;
        constexpr std::size_t variants_each = 2;
        const auto chosen = worth_fitting(d_.screening, all ? task_.candidates.size() : leading, variants_each, all);
        std::vector<std::optional<Model>> models(chosen.size());
        const Model* other = minima_.size() > 1 ? &minima_[1] : nullptr;
        run::Progress progress("fits", 2 * static_cast<std::int64_t>(chosen.size()));
        run::for_each_index(arena_, chosen.size(), [&](std::size_t i) {
            const Model& base = d_.baseline.model;
            const Screened& screened = d_.screening.items[chosen[i]];
            models[i] = fits_.added(base, other, screened, chosen[i], fit_number, INFINITY, false); // some stay
            if (all && !fits_.reaches(models[i], screened) && !task_.candidates[chosen[i]].reading) {
                models[i] = fits_.from_all_sides(base, screened, chosen[i], blind_number, std::move(models[i]),
                                                 INFINITY, false);
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
            if (models[i] && models[i]->sum < std::min(lowest + far * d_.variance,
                                                       d_.baseline.model.sum - something * d_.variance)) {
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

    void collect_effects(const std::vector<std::size_t>& chosen, std::vector<std::optional<Model>>& models) {
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
                effect.fit = judge(std::move(*models[i]));
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

    // The other variants of an effect that were fitted and are not rejected beside its best one.
    std::vector<Alike> alike_of(const EffectResult& effect) const {
        constexpr double rejected = 3.84; // chi2, 95 %
        std::vector<Alike> list;
        for (const auto& [candidate, model] : singles_) {
            const double behind = (model.sum - effect.fit->model.sum) / d_.variance;
            if (candidate != effect.candidate && behind <= rejected &&
                task_.candidates[candidate].effect == task_.candidates[effect.candidate].effect) {
                const auto problem = bench_.problem(model.members);
                list.push_back(
                    {candidate, behind, interval_of(*problem, model, problem->space.axes.size() - 1, d_.variance)});
            }
        }
        std::stable_sort(list.begin(), list.end(), [](const Alike& a, const Alike& b) { return a.behind < b.behind; });
        return list;
    }

    // Everything that depends on the variance.
    void set_statistics() {
        if (!noise_is_stated_) { // the noise is what the best model leaves over
            d_.variance = d_.baseline.model.sum / std::max(1, d_.baseline.dof);
            for (const EffectResult& effect : d_.effects) {
                if (effect.fit) {
                    d_.variance = std::min(d_.variance, effect.fit->model.sum / std::max(1, effect.fit->dof));
                }
            }
            d_.variance = std::max(d_.variance, 1e-24);
        }
        d_.baseline = judge(std::move(d_.baseline.model));
        for (EffectResult& effect : d_.effects) {
            if (effect.fit) {
                effect.fit = judge(std::move(effect.fit->model));
                effect.gain = d_.baseline.chi2 - effect.fit->chi2;
                effect.delta_aicc = effect.fit->aicc - d_.baseline.aicc;
                const auto problem = bench_.problem(effect.fit->model.members);
                effect.size = interval_of(*problem, effect.fit->model, problem->space.axes.size() - 1, d_.variance);
                constexpr double accepted = 3.84; // rise of chi2, 95 %: so much less, and no effect is accepted too
                if (effect.gain < accepted) {
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

    // A fit with an effect may have left the baseline's minimum for a better one: then that is the gain, not the
    // effect's. False: interrupted.
    bool improve_baseline(bool& better) {
        constexpr std::size_t tried = 3;
        for (std::size_t e = 0; e < std::min(tried, d_.effects.size()) && d_.effects[e].fit; ++e) {
            const auto& unit = d_.effects[e].fit->model.unit;
            const std::vector<double> start(unit.begin(), unit.end() - 1);
            constexpr double lower = 0.5; // chi2
            const double known = d_.baseline.model.sum;
            const int number = baseline_number + attempts_++;
            auto found = fits_.lower({}, number, start, d_.screening.base.shift, {}, INFINITY, true);
            if (found && found->sum < known - 0.5 * lower * d_.variance) {
                found = fits_.confirm(found, number);
            }
            if (found && found->sum < d_.baseline.model.sum - lower * d_.variance) {
                set_baseline(*found);
                better = true;
            }
        }
        return !run::interrupted();
    }

    void examine_baseline() {
        const VectorXd residuals = d_.baseline.model.residuals / std::sqrt(d_.variance);
        for (const ReadingGroup& group : task_.groups) {
            d_.groups.push_back(test_group(residuals, group));
        }
        const auto problem = bench_.problem({});
        d_.constancy = test_constancy(problem->residual_jacobian(d_.baseline.model.evaluation) / std::sqrt(d_.variance),
                                      residuals, mimicry_of(d_.baseline.model), task_.groups);
    }

    // What each candidate could explain beside the model that stands at this place of the beam.
    std::optional<Screening> screen_seconds(const Model& base, std::size_t place, std::size_t scanned) {
        return screen(bench_, base, task_.candidates, d_.variance, !noise_is_stated_, task_.seed, scanned,
                      pair_number + 100 * static_cast<int>(place), &d_.screening);
    }

    // One candidate more on each of the best models, those that the screening proposes. of_first: the screening of the
    // first of them. False: interrupted.
    bool fit_pairs(const std::vector<const Judged*>& beam, const Screening& of_first, std::vector<Judged>& pairs) {
        struct Job {
            const Model* base;
            const Screened* screened;
            std::size_t candidate;
            int number;
        };
        const Model& first = beam[0]->model;
        // A second effect has to gain something on the best single one.
        const auto worth = [&] {
            const double beside_single = first.sum - margin * d_.variance;
            return pairs.empty() ? beside_single : std::min(beside_single, worth_beside(pairs[0]));
        };
        const auto fit_seconds = [&](const std::vector<Job>& jobs) {
            const double below = worth();
            return fit_jobs("fits of pairs", jobs.size(), pairs, [&](std::size_t i) {
                const Job& job = jobs[i];
                return fits_.confirm(fits_.added(*job.base, nullptr, *job.screened, job.candidate, job.number,
                                                 fits_.worth_confirming(below), true),
                                     job.number, below);
            });
        };
        const auto add_jobs = [&](const Screening& screening, std::size_t b, std::vector<Job>& jobs) {
            constexpr std::size_t seconds = 5;
            const int number = pair_number + 100 * static_cast<int>(b) + 20;
            for (const std::size_t c : worth_fitting(screening, seconds, 1)) {
                jobs.push_back({&beam[b]->model, &screening.items[c], c, number});
            }
        };
        std::vector<Job> of_leading;
        add_jobs(of_first, 0, of_leading);
        if (!fit_seconds(of_leading)) { // what they reach, the others have to come near
            return false;
        }
        std::vector<Screening> screenings;
        screenings.reserve(beam.size()); // the jobs point into them
        std::vector<Job> of_others;
        for (std::size_t b = 1; b < beam.size(); ++b) {
            auto screening = screen_seconds(beam[b]->model, b, scanned_of_pairs);
            if (!screening) {
                return false;
            }
            screenings.push_back(std::move(*screening));
            add_jobs(screenings.back(), b, of_others);
        }
        if (!fit_seconds(of_others)) {
            return false;
        }
        if (!pairs.empty() && !contradicted(pairs[0], 1.0)) {
            return true;
        }
        // Where one of two effects is fitted alone, the parameters are bent to follow the other, which may then look
        // like nothing there: every effect with the leading one, from a typical size on both sides.
        std::map<std::string, std::size_t> variant; // of each effect the one with the highest score
        for (std::size_t c = 0; c < task_.candidates.size(); ++c) {
            const Screened& item = of_first.items[c];
            const std::string& effect = task_.candidates[c].effect;
            const auto fitted = [&](const Job& job) { return task_.candidates[job.candidate].effect == effect; };
            if (!item.impossible.empty() || task_.candidates[c].reading ||
                std::any_of(of_leading.begin(), of_leading.end(), fitted)) {
                continue;
            }
            const auto [at, is_new] = variant.try_emplace(effect, c);
            if (std::abs(item.score) > std::abs(of_first.items[at->second].score)) {
                at->second = c;
            }
        }
        std::vector<std::size_t> list;
        list.reserve(variant.size());
        for (const auto& [effect, c] : variant) {
            list.push_back(c);
        }
        const double below = worth();
        return fit_jobs("further pairs", list.size(), pairs,
                        [&](std::size_t i) { return fits_.blindly(first, of_first, list[i], blind_number, below); });
    }

    // Adds what so many fits found to the pairs, best first. False: interrupted.
    template <class Fit>
    bool fit_jobs(const char* name, std::size_t count, std::vector<Judged>& pairs, const Fit& fit) {
        std::vector<std::optional<Model>> models(count);
        run::Progress progress(name, static_cast<std::int64_t>(count));
        run::for_each_index(arena_, count, [&](std::size_t i) {
            models[i] = fit(i);
            progress.add(1, true);
        });
        if (run::interrupted()) {
            return false;
        }
        std::stable_sort(models.begin(), models.end(),
                         [](const auto& a, const auto& b) { return a && (!b || a->sum < b->sum); });
        for (auto& model : models) {
            if (!model) {
                break; // those that found nothing come last
            }
            const auto known = std::find_if(pairs.begin(), pairs.end(),
                                            [&](const Judged& pair) { return pair.model.members == model->members; });
            if (known == pairs.end()) {
                pairs.push_back(judge(std::move(*model)));
            } else if (model->sum < known->model.sum) {
                *known = judge(std::move(*model));
            }
        }
        std::stable_sort(pairs.begin(), pairs.end(),
                         [&](const Judged& a, const Judged& b) { return criterion(a) < criterion(b); });
        return true;
    }

    // What each of these explains without the other, where it was not fitted for it promised little. False:
    // interrupted.
    bool fit_alone(const Members& members) {
        for (EffectResult& effect : d_.effects) {
            if (!effect.fit && std::find(members.begin(), members.end(), effect.candidate) != members.end()) {
                if (auto model =
                        fits_.blindly(d_.baseline.model, d_.screening, effect.candidate, blind_number, INFINITY)) {
                    take_single(effect, std::move(*model));
                }
            }
        }
        if (run::interrupted()) {
            return false;
        }
        set_statistics();
        return true;
    }

    const Judged* single_of(std::size_t candidate) const {
        for (const EffectResult& effect : d_.effects) {
            if (effect.candidate == candidate && effect.fit) {
                return &*effect.fit;
            }
        }
        return nullptr;
    }

    // The leading effects again, from points of the sample: a fit may have ended in a local minimum. False:
    // interrupted.
    bool search_further() {
        std::vector<const Explored*> points;
        for (const Explored& point : explored_) {
            points.push_back(&point);
        }
        constexpr std::size_t leading = 6;
        constexpr std::size_t starts = 2;
        const std::size_t count = std::min(starts, points.size());
        std::partial_sort(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(count), points.end(),
                          [](const Explored* a, const Explored* b) {
                              return a->residuals.squaredNorm() < b->residuals.squaredNorm();
                          });
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

    // Fills explanations_ : the models that explain the data, best first; empty: none does. False: interrupted.
    bool explain() {
        const auto is_doubtful = [&](const Judged& j) {
            return noise_is_stated_ && std::min(j.p_value, j.pattern.p_value) < level_doubtful;
        };
        if (!d_.effects.empty() && d_.effects[0].fit && is_doubtful(*d_.effects[0].fit) && !search_further()) {
            return false;
        }
        std::vector<const Judged*> singles;
        for (const EffectResult& effect : d_.effects) {
            if (effect.fit) {
                singles.push_back(&*effect.fit);
            }
        }
        if (singles.empty()) {
            return true;
        }
        const Judged& first = *singles[0];
        const bool is_contradicted = contradicted(first, 1.0);
        auto next = screen_seconds(first.model, 0, is_contradicted ? scanned_of_pairs : 0);
        if (next && !is_contradicted && contradicted(first, next->p_familywise)) {
            next = screen_seconds(first.model, 0, scanned_of_pairs);
        }
        if (!next) {
            return false;
        }
        if (contradicted(first, next->p_familywise)) {
            const std::vector<const Judged*> beam(
                singles.begin(), singles.begin() + static_cast<std::ptrdiff_t>(std::min(singles.size(), beam_width)));
            std::vector<Judged> pairs;
            if (!fit_pairs(beam, *next, pairs)) {
                return false;
            }
            // Does a second effect earn its place?
            const double more = pairs.empty() ? 0.0 : std::max(0.0, first.chi2 - pairs[0].chi2);
            const double p_second = next->family ? next->family->p_value(std::sqrt(more)) : 1.0;
            if (p_second < level_evidence && pairs[0].aicc < first.aicc) {
                explanations_ = std::move(pairs);
                return fit_alone(explanations_[0].model.members);
            }
        }
        for (const Judged* single : singles) {
            explanations_.push_back(*single);
        }
        return true;
    }

    // False: interrupted.
    bool weigh_evidence() {
        return explanations_.empty() || diagnose::weigh_evidence(task_, d_,
                                                                 {.simulations = settings_.bootstrap,
                                                                  .noise_factor = noise_factor_of(explanations_[0]),
                                                                  .number = bootstrap_number});
    }

    // What a model changes in the residuals, beyond what the parameters follow: length 1; empty: nothing.
    VectorXd direction_of(const EffectResult& effect, const Mimicry& mimicry) const {
        VectorXd change = d_.screening.items[effect.candidate].change;
        if (effect.fit) {
            const VectorXd moved = mimicry.beyond(effect.fit->model.residuals - d_.baseline.model.residuals);
            if (moved.squaredNorm() > d_.variance) {
                change = moved;
            }
        }
        const double length = change.norm();
        return length > 0.0 ? VectorXd(change / length) : VectorXd();
    }

    void set_confounding() {
        const Mimicry mimicry = mimicry_of(d_.baseline.model);
        const EffectResult& leading = d_.effects[0];
        const double d = std::sqrt(std::max(0.0, leading.gain));
        const VectorXd own = direction_of(leading, mimicry);
        for (std::size_t e = 1; e < d_.effects.size(); ++e) {
            const VectorXd other = direction_of(d_.effects[e], mimicry);
            if (own.size() == 0 || other.size() == 0) {
                continue;
            }
            double cosine = own.dot(other);
            if (d_.screening.items[d_.effects[e].candidate].sense == 0) {
                cosine = std::abs(cosine);
            }
            d_.confounding.push_back({leading.candidate, d_.effects[e].candidate, cosine,
                                      gsl_cdf_ugaussian_P(d * std::sqrt(std::max(0.0, (1.0 - cosine) / 2.0)))});
        }
        std::stable_sort(d_.confounding.begin(), d_.confounding.end(),
                         [](const auto& a, const auto& b) { return a.rate < b.rate; });
    }

    // Whether these readings cannot tell a candidate from the leading effect.
    bool is_confounded(std::size_t candidate) const {
        return std::any_of(d_.confounding.begin(), d_.confounding.end(),
                           [&](const Confounding& pair) { return pair.b == candidate && pair.rate < least_rate; });
    }

    bool same_effects(const Members& a, const Members& b) const {
        const auto names = [&](const Members& members) {
            std::set<std::string> set;
            for (const std::size_t c : members) {
                set.insert(task_.candidates[c].effect);
            }
            return set;
        };
        return names(a) == names(b);
    }

    // What is an explanation is fitted on the study's own mesh.
    void settle(Judged& explanation) {
        if (explanation.model.mesh == Mesh::coarse) {
            if (auto own = fits_.confirm(explanation.model, fit_number)) {
                explanation = judge(std::move(*own));
            }
        }
    }

    bool decide() {
        // One score among many stood out, but the fits do not bear it out.
        if (!contradicted(d_.baseline, 1.0) && d_.p_evidence >= level_family) {
            d_.verdict = Verdict::adequate;
            return true;
        }
        if (explanations_.empty()) {
            d_.verdict = Verdict::unexplained;
            return true;
        }
        settle(explanations_[0]);
        const Judged& best = explanations_[0];
        const bool is_pair = best.model.members.size() > 1;
        set_confounding();
        d_.extended = best;
        d_.leaves_more_than_noise = contradicted(best, 1.0) || noise_factor_of(best) > 1.0;
        d_.noise_factor = noise_factor_of(best);
        d_.explanations.push_back({best, 0.0});
        for (auto other = explanations_.begin() + 1; other != explanations_.end(); ++other) {
            const bool is_known = std::any_of(d_.explanations.begin(), d_.explanations.end(), [&](const auto& e) {
                return same_effects(e.fit.model.members, other->model.members);
            });
            if (is_known) { // with another variant
                continue;
            }
            const double behind = criterion(*other) - criterion(best);
            const bool is_rejected = contradicted(*other, 1.0);
            // An effect that such readings could not tell from the leading one stands beside it, whatever these say;
            // unless they reject it by themselves and by far.
            const bool is_alike =
                !is_pair && is_confounded(other->model.members[0]) && !(is_rejected && behind > 2.0 * margin);
            if ((behind < margin && (!is_rejected || d_.leaves_more_than_noise)) || is_alike) {
                settle(*other);
                d_.explanations.push_back({*other, criterion(*other) - criterion(best)});
            }
        }
        const bool enough = d_.p_evidence < level_evidence && !d_.leaves_more_than_noise && !best.ends_range();
        if (rejected(best) || d_.p_evidence >= level_unexplained) {
            d_.verdict = Verdict::unexplained;
            d_.nearest = std::move(d_.explanations);
            d_.explanations.clear();
        } else {
            d_.verdict = d_.explanations.size() == 1 && enough ? Verdict::cause_named : Verdict::ambiguous;
            name_causes();
        }
        return true;
    }

    // The effects of the explanations, best first; within one by what each explains alone.
    void name_causes() {
        for (const Explanation& explanation : d_.explanations) {
            Members members = explanation.fit.model.members;
            std::stable_sort(members.begin(), members.end(), [&](std::size_t a, std::size_t b) {
                const Judged* fit_a = single_of(a);
                const Judged* fit_b = single_of(b);
                return fit_a != nullptr && (fit_b == nullptr || fit_a->chi2 < fit_b->chi2);
            });
            for (const std::size_t c : members) {
                const std::string& name = task_.candidates[c].effect;
                if (std::find(d_.causes.begin(), d_.causes.end(), name) == d_.causes.end()) {
                    d_.causes.push_back(name);
                }
            }
        }
    }

    // False: interrupted.
    bool hold_out() {
        if (!d_.extended) {
            return true;
        }
        d_.places = predict_left_out(task_, d_, explored_, task_.places, fold_number);
        if (task_.loads.size() > 1) {
            d_.loads = predict_left_out(task_, d_, explored_, task_.loads,
                                        fold_number + 10 * static_cast<int>(task_.places.size()));
        }
        return !run::interrupted();
    }

    static constexpr double level_unexplained = 0.05;

    const DiagnosisTask& task_;
    Workbench& bench_;
    const DiagnosisSettings& settings_;
    bool noise_is_stated_; // residuals are then in units of it
    tbb::task_arena arena_;
    Diagnosis d_;
    CandidateFits fits_;
    std::vector<Explored> explored_;
    std::vector<Model> minima_; // of the baseline, lowest first
    std::vector<Judged> explanations_;
    std::vector<std::pair<std::size_t, Model>> singles_; // every fit of one effect, by its candidate
    int attempts_ = 0;
};

} // namespace

bool Judged::ends_range(std::size_t member) const {
    constexpr double at_end = 1e-4;
    const double size = model.unit[model.unit.size() - model.members.size() + member];
    return size < at_end || size > 1.0 - at_end;
}

bool Judged::ends_range() const {
    for (std::size_t m = 0; m < model.members.size(); ++m) {
        if (ends_range(m)) {
            return true;
        }
    }
    return false;
}

double aicc(double sum, std::size_t readings, std::size_t parameters, bool noise_is_stated) {
    const auto k = static_cast<double>(parameters);
    if (noise_is_stated) {
        return sum + 2.0 * k;
    }
    const auto n = static_cast<double>(readings);
    const double free = k + 1.0;
    return n * std::log(std::max(sum, 1e-300) / n) + 2.0 * free +
           (n > free + 1.0 ? 2.0 * free * (free + 1.0) / (n - free - 1.0) : INFINITY);
}

Interval interval_within(const problem::Axis& axis, double unit, double variance) {
    constexpr double two_sided = 1.959963984540054;
    const double half = two_sided * std::sqrt(variance);
    return {axis.physical(unit), axis.physical(std::clamp(unit - half, 0.0, 1.0)),
            axis.physical(std::clamp(unit + half, 0.0, 1.0))};
}

Interval interval_of(const problem::Problem& problem, const Model& model, std::size_t axis, double variance) {
    const MatrixXd j = problem.residual_jacobian(model.evaluation);
    MatrixXd h = j.transpose() * j / variance;
    // A parameter on a bound gives way no further; the box is known beforehand.
    constexpr double box_variance = 1.0 / 12.0;
    constexpr double weak = 0.01;
    h.diagonal().array() += weak / box_variance;
    const MatrixXd covariance = h.llt().solve(MatrixXd::Identity(h.rows(), h.cols()));
    const auto k = static_cast<Index>(axis);
    return interval_within(problem.space.axes[axis], model.unit[axis], covariance(k, k));
}

std::optional<Diagnosis> diagnose(const DiagnosisTask& task, const DiagnosisSettings& settings) {
    Diagnostician diagnostician(task, settings);
    if (!diagnostician.run()) {
        return std::nullopt;
    }
    return diagnostician.result();
}

} // namespace explore::diagnose
