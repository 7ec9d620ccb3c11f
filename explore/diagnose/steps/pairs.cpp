// Two effects together.
#include "diagnose/steps/investigation.h"

#include "run/progress.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace explore::diagnose {

namespace {

constexpr std::size_t scanned_of_pairs = 12;
// Below this a fit may be a local minimum: it is searched for another.
constexpr double level_doubtful = 0.05;

} // namespace

// The part that each candidate could explain beside the model that stands at this place of the beam.
std::optional<Screening> Investigation::screen_seconds(const Model& base, std::size_t place, std::size_t scanned) {
    return screen(bench_, base, task_.candidates, d_.variance, !noise_is_stated_, task_.seed, scanned,
                  pair_number + 100 * static_cast<int>(place), &d_.screening);
}

// One candidate more on each of the best models, those that the screening proposes. of_first: the screening of the
// first of them. False: interrupted.
bool Investigation::fit_pairs(const std::vector<const Judged*>& beam, const Screening& of_first,
                              std::vector<Judged>& pairs) {
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
    if (!pairs.empty() && !is_contradicted(pairs[0])) {
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
bool Investigation::fit_jobs(const char* name, std::size_t count, std::vector<Judged>& pairs, const Fit& fit) {
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
            pairs.push_back(judged(std::move(*model)));
        } else if (model->sum < known->model.sum) {
            *known = judged(std::move(*model));
        }
    }
    std::stable_sort(pairs.begin(), pairs.end(),
                     [&](const Judged& a, const Judged& b) { return criterion(a) < criterion(b); });
    return true;
}

// The part that each of these explains without the other, where it was not fitted for it promised little. False:
// interrupted.
bool Investigation::fit_alone(const Members& members) {
    for (EffectResult& effect : d_.effects) {
        if (!effect.fit && std::find(members.begin(), members.end(), effect.candidate) != members.end()) {
            if (auto model = fits_.blindly(d_.baseline.model, d_.screening, effect.candidate, blind_number, INFINITY)) {
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

// Where a single effect leaves something that a second one may explain. False: interrupted.
bool Investigation::fit_two_effects() {
    const auto is_doubtful = [&](const Judged& j) {
        return noise_is_stated_ && std::min(j.p_value, j.pattern.p_value) < level_doubtful;
    };
    // Wrong readings that leave noise need no effects beside them.
    const bool are_readings = !wrong_readings_.empty() && noise_is_stated_ && !is_doubtful(wrong_readings_[0]);
    if (!d_.effects.empty() && d_.effects[0].fit && !are_readings && is_doubtful(*d_.effects[0].fit) &&
        !search_further()) {
        return false;
    }
    const std::vector<const Judged*> singles = fitted_singles();
    if (singles.empty() || are_readings) {
        return true;
    }
    const Judged& first = *singles[0];
    const bool leaves_something = is_contradicted(first);
    auto next = screen_seconds(first.model, 0, leaves_something ? scanned_of_pairs : 0);
    const auto asks_for_more = [&] { return leaves_something || next->p_familywise < level_family; };
    if (next && !leaves_something && asks_for_more()) {
        next = screen_seconds(first.model, 0, scanned_of_pairs);
    }
    if (!next) {
        return false;
    }
    if (!asks_for_more()) {
        return true;
    }
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
        pairs_ = std::move(pairs);
        return fit_alone(pairs_[0].model.members);
    }
    return true;
}

} // namespace explore::diagnose
