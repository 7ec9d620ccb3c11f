#include "analysis/diagnose/diagnose.h"

#include "analysis/common/floor.h"
#include "analysis/common/groups.h"
#include "analysis/diagnose/separating.h"
#include "analysis/diagnose/weigh_premises.h"
#include "base/text.h"
#include "diagnose/evidence.h"
#include "inference/quantiles.h"
#include "landscape/held_ranges.h"
#include "pavement/effects/effect.h"
#include "pavement/layered.h"
#include "study/candidates.h"
#include "study/corrections.h"
#include "study/own_effects.h"
#include "study/readings.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

using diagnose::Diagnosis;
using diagnose::Judged;
using diagnose::Members;

std::vector<study::Variant> variants_of(const std::vector<study::Variant>& all, const Members& members) {
    std::vector<study::Variant> list;
    list.reserve(members.size());
    for (const std::size_t c : members) {
        if (c < all.size()) { // others are coefficients of corrections
            list.push_back(all[c]);
        }
    }
    return list;
}

// The study with the members of a model as parameters.
study::Study extended_by(const DiagnoseResult& result, const Members& members) {
    std::vector<pave::pavement::Correction> corrections;
    for (const std::size_t c : channels_of(result.channels, members)) {
        corrections.push_back(result.corrections[c]);
    }
    return study::with_free_corrections(study::with_free_effects(result.study, variants_of(result.variants, members)),
                                        corrections);
}

// Where bounds or constraints hold the model back, as `fit` has it.
landscape::HeldRanges held_ranges(const problem::Problem& problem, const diagnose::Model& model, double noise_factor) {
    if (!problem.noise_is_stated()) {
        return {};
    }
    const auto there = landscape::minimum_at(model.evaluation, model.unit);
    const auto local = landscape::analyse(there, problem, noise_factor);
    return landscape::held_ranges(problem, there, local, local.bounds_count());
}

DiagnosedModel model_of(const DiagnoseResult& result, diagnose::Workbench& bench, const Judged& judged) {
    DiagnosedModel m{.study = extended_by(result, judged.model.members),
                     .evaluation = judged.model.evaluation,
                     .parameters = {},
                     .held_out_rms = {}};
    const auto problem = bench.problem(judged.model.members);
    const Diagnosis& d = result.diagnosis;
    const bool is_corrected = !channels_of(result.channels, judged.model.members).empty();
    const std::size_t of_study = judged.model.unit.size() - judged.model.members.size();
    const double larger = d.verdict() == diagnose::Verdict::adequate ? d.decision.noise_factor : 1.0;
    const auto held = is_corrected ? landscape::HeldRanges() : held_ranges(*problem, judged.model, larger);
    for (std::size_t k = 0; k < judged.model.unit.size(); ++k) {
        if (is_corrected) {
            m.parameters.push_back(
                diagnose::interval_within(problem->space.axes[k], judged.model.unit[k],
                                          d.location->covariance.diagonal()[static_cast<Eigen::Index>(k)]));
        } else if (!problem->noise_is_stated() && d.baseline.dof <= 0) { // nothing tells what the noise is
            const problem::Axis& axis = problem->space.axes[k];
            m.parameters.push_back({axis.physical(judged.model.unit[k]), axis.low, axis.high});
        } else if (const auto* covariance = d.covariance_by_noise(); covariance != nullptr && k < of_study) {
            m.parameters.push_back(
                diagnose::interval_within(problem->space.axes[k], judged.model.unit[k],
                                          d.variance * covariance->diagonal()[static_cast<Eigen::Index>(k)]));
        } else if (const auto range = held.of(k); range && k < of_study) {
            const problem::Axis& axis = problem->space.axes[k];
            m.parameters.push_back(
                {axis.physical(judged.model.unit[k]), axis.physical(range->low), axis.physical(range->high)});
        } else {
            m.parameters.push_back(k < of_study
                                       ? diagnose::interval_of(*problem, judged.model, k, d.variance * larger * larger)
                                       : judged.sizes[k - of_study]);
        }
    }
    Predictor(m.study).complete(m.evaluation);
    m.held_out_rms = held_out_rms(result.study, m.evaluation.responses);
    m.misfit = study::make_problem(result.study, study::Scope::fitted).misfit(m.evaluation);
    return m;
}

std::vector<diagnose::Candidate> candidates_of(const study::Study& study, const std::vector<study::Variant>& variants,
                                               const Layout& layout) {
    std::vector<diagnose::Candidate> list;
    pave::pavement::Case physical = study.model;
    if (study.has_own_model) { // its corrections are values of parameters
        physical.corrections.clear();
    }
    for (const study::Variant& variant : variants) {
        const auto& effect = *variant.applied.effect;
        const problem::Axis axis = study::size_axis(effect);
        diagnose::Candidate candidate{.effect = std::string(effect.name),
                                      .on = variant.on,
                                      .null = axis.unit(effect.null),
                                      .typical = axis.unit(variant.typical.value_or(effect.typical)),
                                      .reading = {},
                                      .layer = layer_stiffened(study.model, variant.applied),
                                      .high_is_limit = effect.high_is_limit,
                                      .is_layout = !variant.applied.offsets.empty(),
                                      .axis = axis};
        auto changed = readings_changed_alone(physical, variant.applied);
        candidate.is_of_readings = !changed.sensors.empty();
        if (changed.are_scaled) {
            candidate.scaled = std::move(changed.sensors);
        }
        if (effect.is_error_of_reading) {
            candidate.reading =
                std::find(layout.rows.begin(), layout.rows.end(), static_cast<std::size_t>(*variant.applied.reading)) -
                layout.rows.begin();
            candidate.is_of_limit = study.readings[layout.rows[*candidate.reading]].censored != data::Censored::no;
        }
        list.push_back(std::move(candidate));
    }
    return list;
}

// The other minima of the study's model that these readings do not reject beside the best one.
std::vector<std::vector<double>> other_minima(const Diagnosis& d) {
    constexpr double apart = 0.02; // of a range
    std::vector<std::vector<double>> kept{d.baseline.model.unit};
    const double noise = d.variance * std::pow(d.decision.noise_factor, 2);
    for (const diagnose::Model& minimum : d.minima) {
        const auto is_near = [&](const std::vector<double>& known) {
            double most = 0.0;
            for (std::size_t k = 0; k < known.size(); ++k) {
                most = std::max(most, std::abs(known[k] - minimum.unit[k]));
            }
            return most < apart;
        };
        if (minimum.sum - d.baseline.model.sum < inference::chi2_95 * noise &&
            std::none_of(kept.begin(), kept.end(), is_near)) {
            kept.push_back(minimum.unit);
        }
    }
    kept.erase(kept.begin());
    return kept;
}

// Around the model that the answer says: the named one, or the study's over all its minima.
void set_outputs(DiagnoseResult& result, diagnose::Workbench& bench, int threads) {
    const Diagnosis& d = result.diagnosis;
    const bool is_named = d.verdict() == diagnose::Verdict::cause_named && d.extended;
    const bool is_adequate =
        d.verdict() == diagnose::Verdict::adequate || (d.verdict() == diagnose::Verdict::cause_named && !d.extended);
    if (is_adequate) {
        result.minima = other_minima(d);
    }
    if (d.baseline.dof <= 0 && !bench.problem({})->noise_is_stated()) {
        return; // no range can be given
    }
    double noise = std::sqrt(d.variance) * (is_adequate ? d.decision.noise_factor : 1.0);
    if (const auto* covariance = d.covariance_by_noise()) { // as large as independent errors would have to be
        const Eigen::VectorXd plain =
            diagnose::covariance_of(*bench.problem({}), d.baseline.model, d.variance).diagonal();
        noise = std::sqrt(d.variance *
                          std::max(1.0, (d.variance * covariance->diagonal()).cwiseQuotient(plain).maxCoeff()));
    }
    result.outputs = output_ranges(is_named ? result.after->study : result.study,
                                   (is_named ? *d.extended : d.baseline).model.unit, noise, threads, result.minima);
    const DiagnosedModel& shown = result.is_extended() ? *result.after : *result.before;
    for (OutputUncertainty& range : result.outputs) {
        if (!is_named && !is_adequate) {
            range.take_back(shown.evaluation.responses[range.reading]);
        }
        if (result.mesh) {
            result.mesh->outputs.push_back({range.reading, std::expm1(range.of_mesh),
                                            range.deviation > 0.0 ? range.of_mesh / range.deviation : 0.0});
        }
    }
}

// A fault of the readings as a hypothesis: of the effects that the catalogue has, the one that it comes to.
hypotheses::Hypothesis premise_of(const data::BowlFault& fault) {
    const bool is_of_places =
        fault.kind == data::BowlFault::Kind::exchanged || fault.kind == data::BowlFault::Kind::reversed;
    const char* const effect = is_of_places ? "sensor-position" : fault.rows.size() > 1 ? "sensor-gain" : "outlier";
    return {.kind = hypotheses::Kind::layout,
            .name = fault.words(),
            .terms = {{effect, "", std::string(hypotheses::of_readings)}}};
}

// Whether a load that is fitted is computed by the layered engine unless as_diagnosed.
bool is_layered(const study::Study& study) {
    if (study.has_own_model || !study.model.settings.layered) {
        return false;
    }
    const std::vector<bool> fitted = study::fitted_loads(study);
    for (std::size_t l = 0; l < fitted.size(); ++l) {
        if (fitted[l] && pave::pavement::why_not_layered(study.model, static_cast<int>(l)).empty()) {
            return true;
        }
    }
    return false;
}

// The settings that the run which holds the results is kept under.
std::string settings_of(const Session& session, const std::optional<ReducedProblem>& reduced) {
    return fmt::format("seed {}{}", session.options().seed, reduced ? reduced->settings : "");
}

} // namespace

std::vector<double> residuals_of(const DiagnoseResult& result, const diagnose::Model& model) {
    std::vector<double> residuals(result.study.measured().size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t t = 0; t < result.layout.rows.size(); ++t) {
        const std::size_t row = result.layout.rows[t];
        const data::Reading& m = result.study.readings[row];
        const double residual = result.study.data.correlates_noise()
                                    ? m.noise.residual(model.evaluation.responses[row], m.measured())
                                    : model.residuals[static_cast<Eigen::Index>(t)];
        residuals[row] = residual / std::sqrt(result.diagnosis.variance);
    }
    return residuals;
}

std::string DiagnoseResult::extended_study(const std::string& folder) const {
    const auto& model = diagnosis.extended->model;
    const auto own = variants_of(variants, model.members);
    std::vector<double> values = model.evaluation.parameters;
    values.resize(study.space.axes.size() + own.size());
    std::string text = study::extended_text(after->study, own, values, folder);
    if (!diagnosis.is_located()) { // corrections beside a name are no part of its model
        return text;
    }
    // Prior knowledge stands beside noise that is stated.
    const bool with_prior = study.data.misfit == problem::MisfitKind::weighted && diagnosis.variance == 1.0;
    for (const LocatedCorrection& found : located) {
        text += study::correction_text(found.correction, with_prior ? std::optional(found.strength) : std::nullopt,
                                       diagnose::neighbour_correlation);
    }
    return text;
}

study::Study as_diagnosed(study::Study study) {
    study.model.settings.layered = false;
    return study;
}

namespace {

// The readings mended where the premises show how.
std::optional<DiagnoseResult> diagnose_with(Session& session, const study::Study& asked, const DiagnoseOptions& options,
                                            const Premises& premises) {
    const auto begin = std::chrono::steady_clock::now();
    const std::vector<Rounding> steps = roundings(asked);
    const study::Study bottomed = as_diagnosed(premises.no_floor ? *without_floor(asked) : asked);
    const study::Study study = with_enough_load_steps(with_rounding(mended(bottomed, premises.faults), steps), session);
    const problem::Problem baseline = study::make_noise_problem(study, study::Scope::fitted);
    if (baseline.noise_is_student()) {
        throw pave::Error({.file = study.file, .line = study.data.noise_line, .key = "[data.noise] loss"},
                          "the tests of diagnose are those of normal noise", "loss = \"student\"",
                          "loss = \"normal\": a wrong reading is one of the causes that it looks for");
    }
    for (const std::string& name : options.without) {
        study::effect_named(study, name, {.key = "--without"});
    }
    DiagnoseResult result{.study = study,
                          .premises = premises,
                          .roundings = steps,
                          .is_otherwise_layered = is_layered(asked),
                          .options = options,
                          .variants = study::variants(study, options.without),
                          .candidates = {},
                          .corrections = study::correction_channels(study),
                          .channels = {},
                          .layout = layout_of(study),
                          .diagnosis = {},
                          .before = {},
                          .after = {},
                          .mesh = {},
                          .path = {},
                          .outputs = {},
                          .located = {},
                          .next = {},
                          .telling = {},
                          .held_out = {},
                          .reduced = session.reduced(baseline, study, options.model),
                          .tally = {}};
    if (options.model.reduced() && !result.reduced) {
        return std::nullopt;
    }
    result.candidates = candidates_of(study, result.variants, result.layout);
    const std::string settings = settings_of(session, result.reduced);
    for (const auto& correction : result.corrections) {
        const std::size_t first = result.channels.empty() ? result.candidates.size()
                                                          : result.channels.back().first + result.channels.back().count;
        result.channels.push_back({correction.name(), correction.layer, first, correction.factors.size()});
    }
    const auto extended_study = [&](const Members& members) { return extended_by(result, members); };
    session.begin(study, "diagnose", settings);
    const auto model_on = [&](const Members& members, diagnose::Mesh mesh) {
        study::Study extended = extended_study(members);
        return mesh == diagnose::Mesh::coarse ? on_coarser_mesh(std::move(extended)) : extended;
    };
    diagnose::Workbench bench(
        {.problem =
             [&](const Members& members, diagnose::Mesh mesh) {
                 return study::make_noise_problem(model_on(members, mesh), study::Scope::fitted);
             },
         .run = [&](const Members& members,
                    diagnose::Mesh mesh) { return session.begin(model_on(members, mesh), "diagnose", settings); },
         .store = session.store(),
         .threads = session.options().threads,
         .most_numbers = study::most_parameters});
    if (study.has_own_model) { // it has no other mesh
        bench.give_up_coarse();
    }
    diagnose::DiagnosisTask task{.bench = bench,
                                 .candidates = result.candidates,
                                 .groups = result.layout.groups,
                                 .places = result.layout.places,
                                 .loads = result.layout.loads,
                                 .seed = session.options().seed,
                                 .channels = result.channels};
    if (result.reduced) {
        task.explore = [&](const search::Design& sample) {
            auto engine = session.engine(result.reduced->problem, session.begin(study, "explore", settings));
            return engine.evaluate(sample);
        };
    }
    const auto located_in = [&](const Diagnosis& d) {
        const Members& members = d.location->fit.model.members;
        return located(study, extended_study(members), *bench.problem(members), d, result.channels, result.corrections);
    };
    for (const std::size_t row : result.layout.rows) {
        task.noise_places.push_back(study::noise_place(study.model.sensors[row]));
        task.limits.push_back(study.readings[row].censored == data::Censored::no ? 0 : 1);
    }
    for (const data::BowlFault& fault : premises.faults) {
        if (fault.is_mendable()) {
            task.premises.push_back(premise_of(fault));
        }
    }
    if (premises.no_floor) {
        task.premises.push_back(
            {.kind = hypotheses::Kind::effect, .name = no_floor_words(study), .terms = {{"floor-depth", "", ""}}});
    }
    diagnose::Diagnoser diagnoser(task, options.settings);
    if (!diagnoser.find()) {
        return std::nullopt;
    }
    auto says = diagnose::Says::nothing;
    if (diagnoser.found().location) {
        result.located = located_in(diagnoser.found());
        for (const LocatedCorrection& found : result.located) {
            says = std::max(says, found.says_where());
        }
    }
    if (!diagnoser.conclude(says)) {
        return std::nullopt;
    }
    result.diagnosis = diagnoser.result();
    const Diagnosis& d = result.diagnosis;
    if (result.failed()) {
        return result;
    }
    if (!d.shows_location()) {
        result.located.clear();
    }
    const auto reported = [&](const Judged& judged) { return model_of(result, bench, judged); };
    result.before = reported(d.baseline);
    if (d.extended) {
        result.after = reported(*d.extended);
        if (result.before->held_out_rms && result.after->held_out_rms) {
            result.diagnosis.ledger.add(
                diagnose::Ledger::Predicted{.key = d.ledger.rows()[*d.decision.model].hypothesis.key(),
                                            .before = *result.before->held_out_rms,
                                            .after = *result.after->held_out_rms,
                                            .by_study = true});
        }
    }
    const bool is_extended = result.is_extended();
    const diagnose::Model& stands = (is_extended ? *d.extended : d.baseline).model;
    const study::Study& standing = is_extended ? result.after->study : study;
    result.mesh =
        mesh_error(standing, *bench.problem(stands.members), stands.evaluation, stands.unit, std::sqrt(d.variance));
    result.path = path_error(standing, *bench.problem(stands.members), stands.evaluation, std::sqrt(d.variance));
    set_outputs(result, bench, session.options().threads);
    if (d.is_located()) {
        const diagnose::Model& corrected = d.location->fit.model;
        result.telling = telling_readings(result.after->study, corrected.unit, d.location->covariance,
                                          corrected.unit.size() - corrected.members.size());
    }
    const bool is_one = d.explanations.size() == 1 && d.extended && !d.is_corrected();
    if (is_one) { // what would tell most of its sizes, or a doubtful reading once more
        const diagnose::Model& model = d.extended->model;
        for (const std::size_t row : suspected_readings(result.variants, d, 1)) {
            data::Reading reading = study.readings[row];
            if (!study.has_own_model) {
                reading.sigma.reset();
                reading.noise.absolute = study::candidate_noise(study.model.sensors[row].quantity, reading.measured());
            }
            result.next.push_back({.reading = std::move(reading), .again = true, .explanations = {}, .values = {}});
        }
        if (result.next.empty()) {
            result.telling = telling_readings(result.after->study, model.unit,
                                              diagnose::covariance_of(*bench.problem(model.members), model, d.variance),
                                              model.unit.size() - model.members.size());
        }
    }
    if (d.to_compare().size() > 1 && !study.has_own_model) { // what else it can read it does not say
        result.next = separating_readings(study, result.variants, bench, d);
    }
    for (std::size_t e = 0; e < d.explanations.size(); ++e) {
        const bool is_known = e == 0 || !result.before->held_out_rms; // the first is the extended model
        result.held_out.push_back(is_known ? result.after->held_out_rms : reported(d.explanations[e].fit).held_out_rms);
    }
    result.tally = bench.tally();
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return result;
}

} // namespace

std::optional<DiagnoseResult> diagnose(Session& session, const study::Study& asked, const DiagnoseOptions& options) {
    const auto by = [&](const Premises& premises) { return diagnose_with(session, asked, options, premises); };
    auto result = by({.faults = data_faults(asked)});
    result = result ? weigh_premises(asked, std::move(*result), by) : std::nullopt;
    if (result) { // the run of the answer's own model is the one used last
        session.begin(result->study, "diagnose", settings_of(session, result->reduced));
    }
    return result;
}

} // namespace explore::analysis
