#include "analysis/road/road_decision.h"

#include "hypotheses/evidence.h"
#include "inference/nuisance.h"
#include "inference/quantiles.h"
#include "pavement/effects/catalog.h"
#include "study/variants.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>
#include <set>

namespace explore::analysis {

using Eigen::Index;
using Eigen::MatrixXd;
using hypotheses::Kind;

namespace {

// Of residuals beyond everything that the road's parameters follow.
hypotheses::Evidence evidence_beyond(double chi2, double dof, const MatrixXd& by_size, const hypotheses::Prior& prior) {
    return hypotheses::evidence(chi2, static_cast<Index>(std::lround(dof)), by_size, prior, hypotheses::NoisePrior());
}

hypotheses::Hypothesis hypothesis_of(const RoadEffect& effect) {
    return {.kind = effect.kind,
            .name = effect.on.empty() ? effect.name : effect.name + " (" + effect.on + ")",
            .terms = {{.effect = effect.name, .on = effect.on, .subject = ""}}};
}

// Nothing is wrong: with the noise as stated, and of another size.
void add_noise(const RoadDiagnosis& d, const hypotheses::Counts& counts, diagnose::Ledger& ledger) {
    const auto evidence = evidence_beyond(d.chi2, d.dof, MatrixXd(0, 0), hypotheses::Prior::of_parameters(0));
    diagnose::Row none{.hypothesis = {.kind = Kind::none, .name = "nothing is wrong"},
                       .fit = {.chi2 = d.chi2, .dof = static_cast<int>(std::lround(d.dof)), .p_value = d.p_value},
                       .log_prior = hypotheses::log_prior(Kind::none, counts, 1, 0),
                       .log_evidence = evidence.as_stated};
    diagnose::Row size = none;
    ledger.add(std::move(none));
    size.hypothesis = {.kind = Kind::noise, .name = "the noise is of another size than stated"};
    size.log_evidence = evidence.any_size;
    size.noise = evidence.noise;
    size.sizes = {{"noise_factor", evidence.noise, evidence.noise_low, evidence.noise_high}};
    ledger.add(std::move(size));
}

diagnose::Ledger ledger_of(const RoadDiagnosis& d, const std::vector<RoadConfounding>& confounding) {
    std::set<std::string> names;
    for (const RoadEffect& effect : d.effects) {
        names.insert(effect.name);
    }
    const hypotheses::Counts counts{.effects = names.size()};
    diagnose::Ledger ledger(true);
    add_noise(d, counts, ledger);
    double score = 1.0;
    for (std::size_t e = 0; e < d.effects.size(); ++e) {
        const RoadEffect& effect = d.effects[e];
        score = std::min(score, effect.p_familywise);
        const auto variants =
            static_cast<std::size_t>(std::count_if(d.effects.begin(), d.effects.end(), [&](const RoadEffect& other) {
                return other.name == effect.name && other.kind == effect.kind;
            }));
        diagnose::Row row{.hypothesis = hypothesis_of(effect),
                          .log_prior = hypotheses::log_prior(effect.kind, counts, variants, 0),
                          .log_evidence = effect.log_evidence,
                          .model = e};
        if (!effect.chi2) {
            row.not_tried = "not among those that promise most";
            ledger.add(std::move(row));
            continue;
        }
        row.sizes = {{effect.name, effect.size, effect.low, effect.high}};
        row.fit = {.chi2 = *effect.chi2,
                   .dof = static_cast<int>(std::lround(d.dof)) - 1,
                   .numbers = 1,
                   .p_value = effect.p_value,
                   .at_end = effect.ends_range};
        ledger.add(diagnose::Ledger::Chance{row.hypothesis.key(), effect.p_familywise});
        ledger.add(std::move(row));
    }
    ledger.add_score(score);
    const auto key_of = [&](std::size_t candidate) {
        const auto at = std::find_if(d.effects.begin(), d.effects.end(),
                                     [&](const RoadEffect& effect) { return effect.candidate == candidate; });
        return at == d.effects.end() ? std::string() : hypothesis_of(*at).key();
    };
    for (const RoadConfounding& pair : confounding) {
        ledger.add(diagnose::Ledger::Confounded{key_of(pair.a), key_of(pair.b), pair.rate});
    }
    return ledger;
}

} // namespace

double road_evidence(Kind kind, double chi2, double dof, const problem::Axis& axis, double typical, double size,
                     double deviation) {
    auto prior = hypotheses::Prior::of_parameters(0);
    if (kind == Kind::layout) {
        prior.add_layout(axis.unit(axis.start), axis.unit(typical), size);
    } else {
        prior.add_size(axis.unit(axis.start), axis.unit(typical), size);
    }
    prior.cut_off(size, deviation);
    return evidence_beyond(chi2, dof, MatrixXd::Constant(1, 1, 1.0 / deviation), prior).log;
}

void set_gain(RoadEffect& effect, double offset_mm, double share, double deviation, double dof) {
    const auto& gain = *pave::pavement::find_effect(sensor_gain);
    const problem::Axis axis = study::size_axis(gain);
    const double half = inference::two_sided_95 * deviation;
    effect.size = std::exp(share);
    effect.low = std::exp(share - half);
    effect.high = std::exp(share + half);
    const double unit = std::clamp(axis.unit(effect.size), 0.0, 1.0);
    const double in_units = 1.0 / std::log(axis.high / axis.low);
    effect.ends_range = inference::reaches_end(unit, half * in_units, axis.unit(axis.start), gain.high_is_limit);
    effect.log_evidence =
        road_evidence(Kind::effect, *effect.chi2, dof, axis, gain.typical, unit, deviation * in_units);
    effect.words = fmt::format("the sensor at {:g} mm reads {:.1f} % too {}", offset_mm,
                               100.0 * std::abs(effect.size - 1.0), effect.size > 1.0 ? "much" : "little");
}

void decide_on_road(RoadDiagnosis& d, const std::vector<RoadConfounding>& confounding) {
    const diagnose::Ledger ledger = ledger_of(d, confounding);
    d.decision = diagnose::decide(ledger);
    std::vector<std::size_t> order; // of the effects: those of the answer, then the most probable
    const auto take = [&](std::size_t row) {
        const diagnose::Row& own = ledger.rows()[row];
        if (!own.hypothesis.is_of_noise() && std::find(order.begin(), order.end(), own.model) == order.end()) {
            order.push_back(own.model);
        }
    };
    for (const std::size_t row : d.decision.names) {
        take(row);
    }
    const std::size_t named = order.size();
    for (const std::size_t row : d.decision.nearest) {
        take(row);
    }
    for (const auto& ranked : d.decision.hypotheses) {
        take(ranked.row);
    }
    for (std::size_t e = 0; e < d.effects.size(); ++e) {
        if (std::find(order.begin(), order.end(), e) == order.end()) {
            order.push_back(e);
        }
    }
    std::vector<RoadEffect> effects;
    effects.reserve(order.size());
    for (const std::size_t e : order) {
        effects.push_back(std::move(d.effects[e]));
    }
    d.effects = std::move(effects);
    d.causes.clear();
    for (std::size_t cause = 0; cause < named; ++cause) {
        d.causes.push_back(cause);
    }
}

} // namespace explore::analysis
