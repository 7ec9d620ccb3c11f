#include "analysis/design/design.h"

#include "analysis/common/layout.h"
#include "analysis/common/load_steps.h"
#include "analysis/design/design_overlay.h"
#include "analysis/design/design_walks.h"
#include "base/error.h"
#include "base/random.h"
#include "inference/quantiles.h"
#include "run/parallel.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>
#include <limits>

namespace explore::analysis {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using pave::pavement::CriticalPlace;

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

// Of ln(life) by the unit coordinates.
VectorXd gradient_of(const Life& life, const std::vector<double>& unit, const problem::Evaluation& e) {
    return life.gradient(life.critical(life.at(e.parameters), e.responses), unit, e);
}

// Correlation of the logarithms of the lives over what the readings say at a point, to first order.
MatrixXd correlation(const problem::Problem& everything, const std::vector<Life>& lives,
                     const landscape::Acceptance& acceptance, const std::vector<double>& unit,
                     const problem::Evaluation& e) {
    const MatrixXd rows = everything.information_jacobian(e) / acceptance.noise();
    const Index n = rows.cols();
    const MatrixXd information =
        rows.transpose() * rows + MatrixXd::Identity(n, n) / inference::box_variance; // uniform in the box
    MatrixXd gradients(n, static_cast<Index>(lives.size()));
    for (std::size_t l = 0; l < lives.size(); ++l) {
        gradients.col(static_cast<Index>(l)) = gradient_of(lives[l], unit, e);
    }
    MatrixXd covariance = gradients.transpose() * information.llt().solve(gradients);
    const VectorXd deviation = covariance.diagonal().cwiseSqrt().cwiseMax(1e-12);
    covariance = deviation.asDiagonal().inverse() * covariance * deviation.asDiagonal().inverse();
    covariance.diagonal().setOnes();
    return covariance;
}

// How probable it is that each life ends first: normal deviates with that correlation, each stretched to its range on
// either side.
void weigh(std::vector<CriterionLife>& criteria, const MatrixXd& correlations, std::uint64_t seed) {
    const auto n = static_cast<Index>(criteria.size());
    const MatrixXd factor = MatrixXd(correlations + 1e-9 * MatrixXd::Identity(n, n)).llt().matrixL();
    const pave::RandomStream random(seed, 0x11feULL);
    constexpr int draws = 10000;
    std::uint64_t next = 0;
    std::vector<int> first(criteria.size(), 0);
    VectorXd z(n);
    for (int d = 0; d < draws; ++d) {
        for (double& value : z) {
            value = random.normal(next++);
        }
        const VectorXd deviates = factor * z;
        std::size_t least = 0;
        double soonest = INFINITY;
        for (std::size_t l = 0; l < criteria.size(); ++l) {
            const LifeRange& life = criteria[l].allowable;
            const double deviate = deviates[static_cast<Index>(l)] / inference::two_sided_95;
            const double ratio = deviate > 0.0 ? life.high / life.best : life.best / life.low;
            const double repetitions = life.best * std::pow(std::isfinite(ratio) ? ratio : 1.0, deviate);
            const double years = criteria[l].criterion.years_of(repetitions - criteria[l].criterion.passed);
            if (years < soonest) {
                soonest = years;
                least = l;
            }
        }
        ++first[least];
    }
    for (std::size_t l = 0; l < criteria.size(); ++l) {
        criteria[l].governs = static_cast<double>(first[l]) / draws;
    }
}

// As CriterionLife::distribution.
std::vector<std::pair<double, double>> distribution_of(const LifeWalks& walks, std::size_t l, double threshold) {
    std::vector<std::pair<double, double>> distribution;
    const auto add = [&](const LifeEnd& end, std::size_t i, double sign) {
        const double deviate = sign * inference::two_sided_95 * end.way[i].first / std::sqrt(threshold);
        distribution.emplace_back(std::exp(end.log_lives[i]), gsl_cdf_ugaussian_P(deviate));
    };
    for (std::size_t i = walks.shortest[l].way.size(); i > 0; --i) {
        add(walks.shortest[l], i - 1, -1.0);
    }
    for (std::size_t i = 1; i < walks.longest[l].way.size(); ++i) {
        add(walks.longest[l], i, 1.0);
    }
    // The ends are those of full runs, a hair from where the interpolation between runs has the points before them.
    const auto [shortest, longest] = std::minmax(distribution.front().first, distribution.back().first);
    for (auto& [life, probability] : distribution) {
        life = std::clamp(life, shortest, longest);
    }
    return distribution;
}

// Strains that are possible if the model lacks something, at the modulus of the best set; in all seasons alike.
void widen(DesignResult& result, const CriticalPlaces& places, const std::vector<Life>& lives,
           const landscape::Minimum& best, int threads) {
    const problem::Evaluation& here = best.evaluation;
    const auto at_best = lives[0].at(here.parameters);
    study::Study study = places.study; // with the critical places alone
    std::vector<std::size_t> kept;
    for (const Life& life : lives) {
        const std::size_t at = life.critical(at_best, here.responses);
        if (life.criterion().place != CriticalPlace::plate && std::find(kept.begin(), kept.end(), at) == kept.end()) {
            kept.push_back(at);
        }
    }
    study.readings.resize(places.first);
    study.model.sensors.resize(places.first);
    for (const std::size_t i : kept) {
        study.readings.push_back(places.study.readings[i]);
        study.model.sensors.push_back(places.study.model.sensors[i]);
    }
    const auto& acceptance = *result.answer.acceptance;
    const auto ranges = output_ranges(study, best.unit, acceptance.noise_is_stated ? 1.0 : acceptance.noise(), threads);
    for (std::size_t l = 0; l < lives.size(); ++l) {
        const std::size_t at = lives[l].critical(at_best, here.responses);
        for (const OutputUncertainty& range : ranges) {
            if (range.reading < places.first || kept[range.reading - places.first] != at ||
                lives[l].criterion().place == CriticalPlace::plate) {
                continue;
            }
            CriterionLife& c = result.criteria[l];
            c.short_is_held = range.most_is_held;
            c.long_is_held = range.least_is_held;
            if (!(c.strain.best > 0.0)) {
                continue;
            }
            const auto [least, most] = std::minmax({1e6 * std::abs(range.wide_low), 1e6 * std::abs(range.wide_high)});
            const auto life_at = [&](double strain) {
                return std::exp(lives[l].log_repetitions(at, at_best, here.responses, strain / c.strain.best));
            };
            if (c.long_is_held) { // no narrower than if it is right
                c.strain.wide_low = std::min(least, c.strain.low);
                c.allowable.wide_high = std::max(c.allowable.high, life_at(least));
            }
            if (c.short_is_held) {
                c.strain.wide_high = std::max(most, c.strain.high);
                c.allowable.wide_low = std::min(c.allowable.low, life_at(most));
            }
        }
    }
}

// Nothing: interrupted.
std::optional<Overlay> overlay_of(const DesignResult& result, const CriticalPlaces& places,
                                  const std::vector<Life>& lives, const LifeWalks& walks,
                                  const landscape::Minimum& best, int threads) {
    std::vector<double> required;
    for (const CriterionLife& c : result.criteria) {
        required.push_back(c.required);
    }
    const problem::ParameterSpace& space = places.study.space;
    std::vector<std::vector<double>> sets{best.evaluation.parameters};
    const std::size_t ends = walks.shortest.size();
    if (ends > 0) {
        const double threshold = result.answer.acceptance->threshold;
        const double deviate = gsl_cdf_ugaussian_Pinv(0.01 * result.options.reliability_percent);
        for (const LifeEnd& end : walks.shortest) {
            sets.push_back(space.physical(end.at(deviate, threshold)));
        }
        for (const auto* side : {&walks.shortest, &walks.longest}) {
            for (const LifeEnd& end : *side) {
                sets.push_back(space.physical(end.way.back().second));
            }
        }
    }
    std::vector<std::optional<double>> needed(sets.size());
    tbb::task_arena arena(run::concurrency(threads));
    run::for_each_index(arena, sets.size(),
                        [&](std::size_t i) { needed[i] = overlays_needed(places, lives, {required}, sets[i])[0]; });
    if (run::interrupted()) {
        return std::nullopt;
    }
    const auto thickest = [&](std::size_t first, std::size_t last) {
        std::optional<double> most = needed[first];
        for (std::size_t i = first; i < last && most; ++i) {
            most = needed[i] ? std::optional(std::max(*most, *needed[i])) : std::nullopt;
        }
        return most;
    };
    Overlay overlay{.best = needed[0], .low = {}, .high = {}, .reliable = needed[0], .most = thickest_overlay};
    if (ends > 0) {
        overlay.reliable = thickest(1, 1 + ends);
        overlay.high = thickest(1 + ends, needed.size());
        for (const auto& mm : needed) {
            overlay.low = mm && (!overlay.low || *mm < *overlay.low) ? mm : overlay.low;
        }
        if (overlay.reliable && overlay.best) { // a set near the best one may need less
            overlay.reliable = std::max(*overlay.reliable, *overlay.best);
        }
    }
    return overlay;
}

} // namespace

std::optional<DesignResult> design(Session& session, const study::Study& given, const DesignOptions& options) {
    const auto begin = std::chrono::steady_clock::now();
    study::refuse_own_model(given, "design");
    const std::vector<study::Criterion> criteria = study::criteria_of(given);
    if (criteria.empty()) {
        throw pave::Error({.file = given.file, .key = "criteria"},
                          "the study says nothing of what its pavement fails by", {},
                          "at least one [[criteria]] (docs/guide/design.md)");
    }
    const study::Study as_read = with_enough_load_steps(given, session);
    const CriticalPlaces places = critical_places(as_read, criteria);
    const study::Study& study = places.study;
    std::vector<Life> lives;
    for (std::size_t l = 0; l < criteria.size(); ++l) {
        lives.emplace_back(places, criteria[l], places.candidates[l]);
    }
    const problem::Problem fitted = study::make_noise_problem(as_read, study::Scope::fitted);
    const problem::Problem everything = seasonal(study::make_noise_problem(study, study::Scope::everything), places);
    DesignResult result{.study = study, .options = options, .answer = {}, .criteria = {}};
    std::string settings =
        fmt::format("searches of {} evaluations, seed {}", options.settings.max_evaluations, session.options().seed);
    auto reduced = session.reduced(fitted, as_read, options.model);
    if (options.model.reduced() && !reduced) {
        return std::nullopt;
    }
    std::optional<run::Engine> explorer;
    if (reduced) {
        settings += reduced->settings;
        explorer.emplace(reduced->problem, session.store(), session.begin(as_read, "design-explore", settings),
                         session.engine_settings());
    }
    const int lives_run = session.begin(study, "design-lives", settings);
    auto everything_engine = session.engine(everything, lives_run);
    auto engine = session.engine(fitted, session.begin(as_read, "design", settings));
    auto task = uniqueness_task(as_read, fitted, everything, engine, everything_engine, session.options().seed);
    task.outputs.clear(); // lives are walked, not strains
    task.explorer = explorer ? &*explorer : nullptr;
    auto answer = landscape::uniqueness(task, options.settings);
    if (!answer) {
        return std::nullopt;
    }
    result.answer = std::move(*answer);
    if (result.answer.minima.empty()) {
        result.failure = run::why_no_minimum(fitted, result.answer.explored);
        return result;
    }
    landscape::Minimum best = result.answer.minima[0];
    best.evaluation = everything_engine.evaluate_one(best.unit);
    if (!best.evaluation.converged()) {
        result.failure = "the best set has no answer under the axle: " + best.evaluation.reason;
        return result;
    }
    const auto at_best = lives[0].at(best.evaluation.parameters);
    for (std::size_t l = 0; l < lives.size(); ++l) {
        const std::size_t at = lives[l].critical(at_best, best.evaluation.responses);
        CriterionLife c{.criterion = criteria[l], .place = study.readings[at]};
        c.strain = {lives[l].strain(at, best.evaluation.responses), unknown, unknown, unknown, unknown};
        const double log_life = lives[l].log_repetitions(at, at_best, best.evaluation.responses);
        c.allowable = {std::exp(log_life), unknown, unknown, unknown, unknown};
        c.required = criteria[l].passed + criteria[l].design_traffic.value_or(criteria[l].traffic_of(options.years));
        result.criteria.push_back(std::move(c));
    }
    LifeWalks walks;
    if (!result.answer.acceptance) {
        result.no_range = result.answer.missing.empty() ? "the noise is not known" : result.answer.missing.back();
    } else {
        // Where a law reads the modulus, too, its shortest life is not that of the largest strain.
        std::vector<Life> ends = lives;
        std::vector<std::size_t> of_strain(lives.size());
        for (std::size_t l = 0; l < lives.size(); ++l) {
            of_strain[l] = l;
            if (study::Criterion by_strain = criteria[l]; by_strain.reads_modulus() && !by_strain.modulus_MPa) {
                by_strain.modulus_MPa = lives[l].modulus(at_best);
                of_strain[l] = ends.size();
                ends.emplace_back(places, by_strain, places.candidates[l]);
            }
        }
        auto walked = walk_lives({.session = session,
                                  .answer = result.answer,
                                  .places = places,
                                  .lives = ends,
                                  .fitted = reduced ? reduced->problem : fitted,
                                  .everything = everything,
                                  .settings = settings},
                                 best.evaluation);
        if (!walked) {
            return std::nullopt;
        }
        walks = std::move(*walked);
        session.begin(as_read, "design", settings); // the run used last
        for (std::size_t l = 0; l < lives.size(); ++l) {
            CriterionLife& c = result.criteria[l];
            c.allowable.low = std::min(c.allowable.best, std::exp(walks.shortest[l].log_life));
            c.allowable.high = std::max(c.allowable.best, std::exp(walks.longest[l].log_life));
            c.strain.low = std::min(c.strain.best, walks.longest[of_strain[l]].strain);
            c.strain.high = std::max(c.strain.best, walks.shortest[of_strain[l]].strain);
            c.distribution = distribution_of(walks, l, result.answer.acceptance->threshold);
        }
        widen(result, places, lives, best, session.options().threads);
        weigh(result.criteria, correlation(everything, lives, *result.answer.acceptance, best.unit, best.evaluation),
              session.options().seed);
    }
    for (CriterionLife& c : result.criteria) {
        c.set_remaining();
    }
    result.overlay = overlay_of(result, places, lives, walks, best, session.options().threads);
    if (!result.overlay) {
        return std::nullopt;
    }
    if (result.answer.acceptance) {
        const auto ends_first = static_cast<std::size_t>(&result.governing() - result.criteria.data());
        result.next = narrowing_steps(as_read, fitted, *result.answer.acceptance, result.answer.minima[0],
                                      gradient_of(lives[ends_first], best.unit, best.evaluation));
    }
    result.computed = engine.tally().computed + everything_engine.tally().computed + walks.computed;
    result.kept = engine.tally().kept + everything_engine.tally().kept + walks.kept;
    result.runs_between = walks.between;
    result.off_between = walks.off;
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return result;
}

} // namespace explore::analysis
