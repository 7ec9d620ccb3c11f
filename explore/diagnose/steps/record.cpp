// The results as rows of the ledger.
#include "diagnose/open_directions.h"
#include "diagnose/simulated_data.h"
#include "diagnose/steps/investigation.h"
#include "hypotheses/noise_structure.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>
#include <map>
#include <set>

namespace explore::diagnose {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using hypotheses::Kind;

namespace {

Fit fit_of(const Judged& j) {
    return {.mesh = j.model.mesh,
            .chi2 = j.chi2,
            .dof = j.dof,
            .numbers = static_cast<int>(j.model.members.size()),
            .p_value = j.p_value,
            .pattern_chi2 = j.pattern.chi2,
            .pattern_dof = j.pattern.dof,
            .p_pattern = j.pattern.p_value,
            .at_end = j.at_end};
}

} // namespace

hypotheses::Term Investigation::term_of(std::size_t candidate) const {
    const Candidate& own = task_.candidates[candidate];
    return {.effect = own.effect,
            .on = own.on,
            .subject = own.is_of_readings ? std::string(hypotheses::of_readings) : own.layer};
}

Kind Investigation::kind_of(std::size_t candidate) const {
    const Candidate& own = task_.candidates[candidate];
    return own.reading ? Kind::readings : own.is_layout ? Kind::layout : Kind::effect;
}

hypotheses::Counts Investigation::counts() const {
    std::set<std::string> effects;
    hypotheses::Counts counts{.readings = 0, .effects = 0, .channels = task_.channels.size()};
    for (const Candidate& candidate : task_.candidates) {
        if (candidate.reading) {
            ++counts.readings;
        } else {
            effects.insert(candidate.effect);
        }
    }
    counts.effects = effects.size();
    return counts;
}

// Of a model with effects, by what they are.
hypotheses::Hypothesis Investigation::hypothesis_of(const Judged& fit, Kind kind) const {
    hypotheses::Hypothesis hypothesis{.kind = kind, .name = ""};
    for (const std::size_t c : fit.model.members) {
        hypothesis.terms.push_back(term_of(c));
        const auto& term = hypothesis.terms.back();
        hypothesis.name += hypothesis.name.empty() ? "" : " with ";
        hypothesis.name += term.on.empty() ? term.effect : fmt::format("{} ({})", term.effect, term.on);
    }
    return hypothesis;
}

std::string Investigation::key_of(const Judged& fit, Kind kind) const {
    return hypothesis_of(fit, kind).key();
}

void Investigation::record(const Judged& fit, Kind kind, int order) {
    Row row{.hypothesis = hypothesis_of(fit, kind), .fit = fit_of(fit), .order = order};
    std::size_t variants = 1;
    std::size_t bad = 0;
    for (const std::size_t c : fit.model.members) {
        variants *= task_.candidates[c].reading && kind == Kind::readings ? 1 : variants_of(c);
        bad += task_.candidates[c].reading ? 1 : 0;
    }
    row.log_prior = hypotheses::log_prior(kind, counts(), variants, bad);
    row.log_evidence = fit.evidence.log;
    row.noise = fit.evidence.noise;
    for (std::size_t m = 0; m < fit.model.members.size(); ++m) {
        const auto& term = row.hypothesis.terms[m];
        const Interval& size = fit.sizes[m];
        row.sizes.push_back({kind == Kind::readings ? term.on : term.effect, size.value, size.low, size.high});
    }
    row.model = models_.size();
    models_.push_back(fit);
    d_.ledger.add(std::move(row));
}

// Of the hypotheses that lead, the volume where their derivatives leave a direction open. True: a probability changed.
bool Investigation::look_along_open_directions() {
    constexpr double near = 9.0; // of the logarithm of a probability
    const std::vector<std::size_t> all = rows_that_count(d_.ledger);
    double best = -INFINITY;
    for (const std::size_t r : all) {
        const Row& row = d_.ledger.rows()[r];
        best = row.is_tried() ? std::max(best, row.log_weight()) : best;
    }
    std::map<std::size_t, std::vector<std::size_t>> rows_of; // by the model
    for (const std::size_t r : all) {
        const Row& row = d_.ledger.rows()[r];
        if (row.is_tried() && row.fit.mesh == Mesh::study && row.log_weight() > best - near &&
            !looked_.contains(row.model)) {
            rows_of[row.model].push_back(r);
        }
    }
    bool changed = false;
    for (const auto& [number, rows] : rows_of) {
        looked_.insert(number);
        Model model = models_[number].model;
        if (model.evaluation.jacobian.size() == 0 ||
            !bench_.chain(model.members, open_number,
                          [&](const problem::Problem& problem, run::Chain& chain) {
                              model.open_rows = rows_of_open_directions(problem, model, d_.variance, chain);
                          }) ||
            model.open_rows.rows() == 0) {
            continue;
        }
        const Judged now = judged(std::move(model));
        const Judged& before = models_[number];
        if (!now.model.members.empty()) {
            const Kind kind = d_.ledger.rows()[rows[0]].hypothesis.kind;
            record(now, kind, 2);
            looked_.insert(models_.size() - 1);
        } else {
            d_.baseline = now;
            models_.push_back(now);
            looked_.insert(models_.size() - 1);
            for (const std::size_t r : rows) {
                Row row = d_.ledger.rows()[r];
                row.log_evidence += row.hypothesis.kind == Kind::none && noise_is_stated_
                                        ? now.evidence.as_stated - before.evidence.as_stated
                                        : now.evidence.any_size - before.evidence.any_size;
                row.order = 2;
                row.model = models_.size() - 1;
                if (const auto at = d_.by_noise.find(r); at != d_.by_noise.end()) {
                    d_.by_noise.emplace(d_.ledger.rows().size(), at->second);
                }
                d_.ledger.add(std::move(row));
            }
        }
        constexpr double something = 0.3;
        changed = changed || std::abs(now.evidence.log - before.evidence.log) > something;
    }
    return changed;
}

// The study's model: with the noise as stated, of another size, with errors that readings share, with heavy tails.
void Investigation::record_noise() {
    const Judged& baseline = d_.baseline;
    Row none{.hypothesis = {.kind = Kind::none, .name = "nothing is wrong"}, .fit = fit_of(baseline)};
    none.log_prior = hypotheses::log_prior(Kind::none, counts(), 1, 0);
    none.log_evidence = noise_is_stated_ ? baseline.evidence.as_stated : baseline.evidence.any_size;
    none.model = models_.size();
    models_.push_back(baseline);
    d_.ledger.add_score(d_.screening.p_familywise);
    Row size = none;
    d_.ledger.add(std::move(none));
    if (!noise_is_stated_) {
        return;
    }
    const auto& evidence = baseline.evidence;
    size.hypothesis = {.kind = Kind::noise, .name = "the noise is of another size than stated"};
    size.log_evidence = evidence.any_size;
    size.noise = evidence.noise;
    size.noise_by_data = evidence.by_data;
    size.sizes = {{"noise_factor", evidence.by_data, evidence.noise_low, evidence.noise_high}};
    size.fit.p_value = gsl_cdf_chisq_Q(baseline.chi2 / std::pow(evidence.noise, 2), std::max(1, baseline.dof));
    d_.ledger.add(size);
    const auto problem = bench_.problem({});
    if (task_.noise_places.size() != problem->readings() || problem->noise_is_correlated() ||
        problem->noise_is_student() || problem->readings() != problem->rows()) {
        return;
    }
    // Of limits errors cannot be seen; parameters that are pressed against a bound follow nothing.
    std::vector<Index> drawn;
    std::vector<data::NoisePlace> places;
    for (std::size_t i = 0; i < task_.noise_places.size(); ++i) {
        if (!task_.is_limit(i)) {
            drawn.push_back(static_cast<Index>(i));
            places.push_back(task_.noise_places[i]);
        }
    }
    MatrixXd jacobian = problem->residual_jacobian(baseline.model.evaluation);
    const VectorXd pull = jacobian.transpose() * baseline.model.residuals;
    for (Index k = 0; k < jacobian.cols(); ++k) {
        if (inference::is_pressed(baseline.model.unit[static_cast<std::size_t>(k)], pull[k])) {
            jacobian.col(k).setZero();
        }
    }
    const hypotheses::LinearFit linear{baseline.model.residuals(drawn), jacobian(drawn, Eigen::all)};
    const double of_limits = baseline.model.residuals.squaredNorm() - linear.residuals.squaredNorm();
    const auto add = [&](const hypotheses::NoiseStructure& structure, std::string name, std::string unit) {
        Row row{.hypothesis = {.kind = Kind::noise, .name = std::move(name)},
                .sizes = {{std::move(unit), structure.size, structure.low, structure.high}},
                .fit = fit_of(baseline)};
        row.fit.chi2 = structure.chi2 + of_limits;
        row.fit.p_value = baseline.dof > 0 ? gsl_cdf_chisq_Q(row.fit.chi2, baseline.dof) : 1.0;
        row.fit.pattern_dof = 0; // of that noise patterns are expected
        row.fit.p_pattern = 1.0;
        row.log_prior = hypotheses::log_prior_of_structure(structure.key, counts());
        row.log_evidence = structure.evidence.log - 0.5 * of_limits;
        row.noise = structure.evidence.any_size > structure.evidence.as_stated ? structure.evidence.noise : 1.0;
        row.model = 0;
        row.is_independent = row.has_tails = structure.key == "heavy-tailed";
        row.ends = structure.ends;
        if (structure.covariance.size() > 0) {
            d_.by_noise.emplace(d_.ledger.rows().size(), row.noise * row.noise * structure.covariance);
        }
        d_.ledger.add(std::move(row));
    };
    std::map<int, Index> column;
    for (const auto& place : places) {
        column.try_emplace(place.load, static_cast<Index>(column.size()));
    }
    if (column.size() > 1) { // of one load all are those of another load
        MatrixXd common = MatrixXd::Zero(linear.residuals.size(), static_cast<Index>(column.size()));
        for (std::size_t i = 0; i < places.size(); ++i) {
            const auto row = static_cast<std::size_t>(drawn[i]);
            common.col(column[places[i].load]) += problem->change_by_gain(row, baseline.model.evaluation)(drawn);
        }
        add(hypotheses::common_errors(linear, common, judge_.noise_prior()), "errors that the readings of a load share",
            "common_relative");
    }
    // Readings taken twice in one place at one time, as far as is stated, say nothing of distances.
    const bool have_places = std::none_of(places.begin(), places.end(), [&](const auto& place) {
        return std::count_if(places.begin(), places.end(), [&](const auto& other) {
                   return data::is_one_sensor(place, other) && place.time == other.time;
               }) > 1;
    });
    if (have_places) {
        add(hypotheses::correlated_errors(linear, places, judge_.noise_prior()),
            "errors of neighbouring readings are alike", "correlation_m");
    }
    add(hypotheses::heavy_tails(linear, judge_.noise_prior()), "errors with heavy tails", "degrees");
}

// Every variant that was fitted is a hypothesis of its own; what was not, with its reason.
// Other instruments whose error the readings do not tell from that of the first: each is a cause of its own.
std::vector<Alike> Investigation::other_instruments(const EffectResult& effect) const {
    constexpr double same = 1.0; // chi2: the readings do not tell them apart at all
    std::vector<Alike> others;
    for (const Alike& other : effect.alike) {
        const Candidate& candidate = task_.candidates[other.candidate];
        if (candidate.is_of_readings && !candidate.reading && other.behind < same) {
            others.push_back(other);
        }
    }
    return others;
}

void Investigation::record_singles() {
    for (const EffectResult& effect : d_.effects) {
        if (effect.fit) {
            record(*effect.fit, kind_of(effect.candidate));
            for (const Alike& other : other_instruments(effect)) {
                record(judged(other.model), kind_of(other.candidate));
            }
            continue;
        }
        const auto term = term_of(effect.candidate);
        d_.ledger.add(Row{.hypothesis = {.kind = kind_of(effect.candidate), .name = term.effect, .terms = {term}},
                          .not_tried = effect.impossible});
    }
}

// How often noise makes so much of what single effects gain. False: interrupted.
bool Investigation::weigh_chances() {
    const std::vector<const Judged*> singles = fitted_singles();
    if (singles.empty()) {
        return true;
    }
    const Judged& best = pairs_.empty() ? *singles[0] : pairs_[0];
    const double excess =
        noise_is_stated_ && best.dof > 0 && best.p_value < level_noise ? std::sqrt(best.chi2 / best.dof) : 1.0;
    if (!diagnose::weigh_evidence(
            task_, d_, {.simulations = settings_.bootstrap, .noise_factor = excess, .number = bootstrap_number})) {
        return false;
    }
    for (const EffectResult& effect : d_.effects) {
        if (effect.fit) {
            const double gain = std::max(0.0, effect.gain) / (d_.bartlett * excess * excess);
            const double p = d_.screening.family ? d_.screening.family->p_value(std::sqrt(gain)) : 1.0;
            d_.ledger.add(Ledger::Chance{key_of(*effect.fit, kind_of(effect.candidate)), p});
            for (const Alike& other : other_instruments(effect)) {
                d_.ledger.add(Ledger::Chance{key_of(judged(other.model), kind_of(other.candidate)), p});
            }
        }
    }
    for (const Judged& pair : pairs_) {
        d_.ledger.add(Ledger::Chance{key_of(pair, Kind::effects), d_.p_evidence});
    }
    return true;
}

// The change of the residuals by a model, beyond what the parameters follow: length 1; empty: nothing.
VectorXd Investigation::direction_of(const EffectResult& effect, const inference::Nuisance& nuisance) const {
    VectorXd change = d_.screening.items[effect.candidate].change;
    if (effect.fit) {
        const VectorXd moved = nuisance.beyond(effect.fit->model.residuals - d_.baseline.model.residuals);
        if (moved.squaredNorm() > d_.variance) {
            change = moved;
        }
    }
    const double length = change.norm();
    return length > 0.0 ? VectorXd(change / length) : VectorXd();
}

void Investigation::weigh_confounding() {
    if (d_.effects.empty() || !d_.effects[0].fit) {
        return;
    }
    const inference::Nuisance nuisance = nuisance_of(d_.baseline.model);
    const EffectResult& leading = d_.effects[0];
    const double d = std::sqrt(std::max(0.0, leading.gain));
    const VectorXd own = direction_of(leading, nuisance);
    const auto key = [&](const EffectResult& effect) { return key_of(*effect.fit, kind_of(effect.candidate)); };
    for (std::size_t e = 1; e < d_.effects.size(); ++e) {
        const VectorXd other = direction_of(d_.effects[e], nuisance);
        if (own.size() == 0 || other.size() == 0) {
            continue;
        }
        double cosine = own.dot(other);
        if (d_.screening.items[d_.effects[e].candidate].sense == 0) {
            cosine = std::abs(cosine);
        }
        const double rate = gsl_cdf_ugaussian_P(d * std::sqrt(std::max(0.0, (1.0 - cosine) / 2.0)));
        d_.confounding.push_back({leading.candidate, d_.effects[e].candidate, cosine, rate});
        if (d_.effects[e].fit) {
            d_.ledger.add(Ledger::Confounded{key(leading), key(d_.effects[e]), rate});
        }
    }
    std::stable_sort(d_.confounding.begin(), d_.confounding.end(),
                     [](const auto& a, const auto& b) { return a.rate < b.rate; });
}

} // namespace explore::diagnose
