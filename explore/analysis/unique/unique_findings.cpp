#include "analysis/common/knowledge_words.h"
#include "analysis/common/layout.h"
#include "analysis/common/limit_words.h"
#include "analysis/common/range_shape.h"
#include "analysis/common/say.h"
#include "analysis/common/sought_noise.h"
#include "analysis/unique/unique.h"

#include "base/error.h"
#include "base/text.h"
#include "external/model.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {

using landscape::Branch;
using landscape::Range;
using landscape::Uniqueness;
using landscape::Verdict;
using landscape::WalkEnd;
using pave::counted;
using pave::figure;
using pave::p_words;

namespace {

// A sentence on a parameter that is an exponent of a layer's law.
std::optional<pave::material::StressPower> power_of(const study::Study& study, std::size_t axis) {
    const auto& parameter = study.parameters[axis];
    if (!parameter.law_index) {
        return std::nullopt;
    }
    const auto& law = *study.model.layers[static_cast<std::size_t>(parameter.owner)].law;
    return law.parameters()[*parameter.law_index].power;
}

std::string model_words(const ModelOptions& model) {
    return model.alone()
               ? fmt::format("All of this is the reduced model's, whose error is estimated below {} % of a reading "
                             "where it was used; --model auto gives the same for the full model, with the ranges of "
                             "the outputs.",
                             figure(model.limit_percent))
               : "The reduced model explored and searched. Every minimum it found was searched for again by the full "
                 "model, which gives the minima, ranges and verdict here.";
}

// The verdict `unique` with what takes it back: data that contradict the model, parameters that the box holds.
std::string unique_words(const problem::ParameterSpace& space, const Uniqueness& u, bool contradicts_constraint) {
    std::string text = "UNIQUE within what was searched: one set of parameters, with the ranges below, fits these data";
    const auto& bounds = u.minima[0].on_bound;
    if (u.priors && !u.priors->only.empty()) {
        text = fmt::format("UNIQUE ONLY BY THE PRIOR: the readings alone do not determine {}; with what is known "
                           "beforehand one set of parameters, with the ranges below, fits",
                           pave::join(names_of(space, u.priors->only)));
    }
    if (u.acceptance->widened) {
        text = fmt::format("UNIQUE, but the data contradict the model ({}): one set of parameters, with the ranges "
                           "below, fits best",
                           p_words(u.acceptance->p_value));
    }
    if (u.priors && u.priors->is_contradicted()) {
        text = fmt::format("UNIQUE, but the readings contradict a prior ({}): one set of parameters, with the ranges "
                           "below, fits both best",
                           p_words(u.priors->p_value));
    }
    if (contradicts_constraint) {
        text =
            "UNIQUE, but the readings contradict a constraint: one set of parameters, with the ranges below, fits best "
            "where it holds";
    }
    if (!bounds.empty()) {
        text += fmt::format("; limited by the bound: {}. Widen it if other values are possible",
                            pave::join(bound_words(space, bounds)));
    }
    return text + ".";
}

} // namespace

std::string conflict_words(const problem::ParameterSpace& space, const Eigen::VectorXd& direction) {
    const double seen = direction.size() > 0 ? 0.3 * direction.cwiseAbs().maxCoeff() : 0.0;
    std::vector<std::string> words;
    for (Eigen::Index k = 0; k < direction.size(); ++k) {
        if (std::abs(direction[k]) > seen) {
            words.push_back((direction[k] > 0.0 ? "higher " : "lower ") + space.axes[static_cast<std::size_t>(k)].name);
        }
    }
    return pave::join(words);
}

namespace {

// Digits of a coefficient that is multiplied by something that varies over `span`: the rounding shows less than a tenth
// of what the combination is fixed to.
int digits_for(double coefficient, double span, double fixed_to) {
    constexpr double share = 0.1;
    constexpr int least = 3;
    constexpr int most = 9;
    const double rounding = 2.0 * share * fixed_to / std::max(std::abs(coefficient) * span, 1e-300);
    return std::clamp(static_cast<int>(std::ceil(1.0 - std::log10(std::max(rounding, 1e-300)))), least, most);
}

// How far s(parameter) reaches over the box.
double span_of(const problem::Axis& axis) {
    return axis.scale == problem::Scale::log ? std::log(axis.high / axis.low) : axis.high - axis.low;
}

} // namespace

// A factor c^k of the fixed combination is a power of stress at a stress of its own. A pressure, a thickness, a ratio:
// known only by the change of its logarithm here, which a power keeps along the whole valley where the data see a
// product or a quotient.
std::string combination_words(const study::Study& study, const landscape::Combination& c,
                              const std::vector<double>& unit) {
    const problem::ParameterSpace& space = study.space;
    const auto is_log = [&](std::size_t k) { return space.axes[k].scale == problem::Scale::log; };
    constexpr double pa_kPa = 100.0;
    std::string text = space.axes[c.leading].name;
    for (const auto& term : c.others) {
        const problem::Axis& axis = space.axes[term.axis];
        const std::string& name = axis.name;
        const double span = span_of(axis);
        const int digits = digits_for(term.coefficient, span, c.standard_error);
        if (!is_log(c.leading)) {
            text += fmt::format(" {} {:.{}g} * {}", term.coefficient < 0.0 ? "-" : "+", std::abs(term.coefficient),
                                digits, is_log(term.axis) ? "ln(" + name + ")" : name);
            continue;
        }
        if (is_log(term.axis)) {
            text += fmt::format(" * {}^{:.{}g}", name, term.coefficient, digits);
            continue;
        }
        const double base = std::exp(term.coefficient);
        const int digits_of_base = digits_for(1.0, span, c.standard_error);
        const auto power = power_of(study, term.axis);
        if (power && base > power->offset) {
            text += fmt::format(" * ({0}/pa{1})^{2} at {0} = {3:.{4}g} kPa", power->stress,
                                power->offset > 0.0 ? fmt::format(" + {:g}", power->offset) : "", name,
                                pa_kPa * (base - power->offset), digits_of_base);
        } else if (axis.low > 0.0) {
            const double exponent = term.coefficient * axis.physical(unit[term.axis]);
            text += fmt::format(" * {}^{:.{}g}", name, exponent,
                                digits_for(exponent, std::log(axis.high / axis.low), c.standard_error));
        } else {
            text += fmt::format(" * {:.{}g}^{}", base, digits_of_base, name);
        }
    }
    return text + (is_log(c.leading) ? fmt::format(" is fixed to {:.2g} %", 100.0 * c.standard_error)
                                     : fmt::format(" is fixed to {:.2g}", c.standard_error));
}

std::string end_words(WalkEnd end, const std::vector<std::string>& bounds) {
    switch (end) {
    case WalkEnd::threshold: return bounds.empty() ? "the data" : "the data, with " + pave::join(bounds);
    case WalkEnd::bound: return bounds.empty() ? "the box" : pave::join(bounds);
    case WalkEnd::hole: return "points without an answer";
    case WalkEnd::better: return "a lower misfit found";
    case WalkEnd::limit: return "the limit of steps";
    }
    return "";
}

std::string end_words(const problem::Problem& problem, WalkEnd end, const std::vector<landscape::BoundMet>& met,
                      const std::vector<std::size_t>& limits) {
    std::vector<std::string> words = bound_words(problem.space, met);
    for (const std::size_t i : limits) {
        words.push_back("the constraint " + problem.limits[i]->text());
    }
    return end_words(end, words);
}

std::vector<std::string> names_of(const problem::ParameterSpace& space, const std::vector<std::size_t>& axes) {
    std::vector<std::string> names;
    names.reserve(axes.size());
    for (const std::size_t k : axes) {
        names.push_back(space.axes[k].name);
    }
    return names;
}

std::vector<std::string> findings(const UniqueResult& result) {
    std::vector<std::string> text;
    const study::Study& study = result.study;
    const problem::ParameterSpace& space = result.problem.space;
    const Uniqueness& u = result.answer;
    const NextReading& next = result.next;
    const auto outputs = study.outputs();
    const auto say = [&](std::string sentence) { analysis::say(text, std::move(sentence)); };
    const auto constraints = u.acceptance ? active_constraints(result.problem, u.minima[0]) : ActiveConstraints{};
    switch (u.verdict) {
    case Verdict::unique: say(unique_words(space, u, constraints.contradicted)); break;
    case Verdict::non_unique:
        say((u.acceptance && u.acceptance->widened
                 ? fmt::format("NON-UNIQUE, and the data contradict the model ({}): ", p_words(u.acceptance->p_value))
                 : "NON-UNIQUE: ") +
            (!u.alternatives && !u.wide.empty()
                 ? fmt::format("around the one minimum the data accept more than half of what the study allows for {}.",
                               pave::join(names_of(space, u.wide), " and "))
             : u.alternatives && u.valley
                 ? "separate minima fit these data, and a continuous valley of parameter sets too."
             : u.alternatives ? "separate minima fit these data, with no acceptable way found between them."
             : space.axes.size() == 1
                 ? fmt::format("the data hardly determine {}: every value between {} and {} fits them.",
                               space.axes[0].name, figure(u.parameters[0].low), figure(u.parameters[0].high))
                 : "a continuous valley of parameter sets fits these data equally well."));
        break;
    case Verdict::undecided: say("UNDECIDED. What is missing: " + pave::join(u.missing) + "."); break;
    }
    if (!u.acceptance) {
        return text;
    }
    const auto& acceptance = *u.acceptance;
    if (u.verdict == Verdict::non_unique && !u.missing.empty()) {
        say("Not settled beyond that: " + pave::join(u.missing) + ".");
    }
    say(constraints.words);
    if (u.priors) {
        for (std::string& sentence : prior_findings(result.problem, *u.priors)) {
            say(std::move(sentence));
        }
    }
    if (!u.directions.free.empty()) {
        std::vector<std::string> fixed;
        for (const auto& c : u.directions.fixed) {
            fixed.push_back(combination_words(study, c, u.directions.unit));
        }
        say(fmt::format("At the best minimum the data do not determine {} individually{}",
                        pave::join(names_of(space, u.directions.free)),
                        fixed.empty() ? "." : ", but " + pave::join(fixed) + "."));
    }
    if (!u.directions.dead.empty()) {
        say(fmt::format(
            "No reading is sensitive to {} here: with the sensitivities at the best fit, crossing the whole "
            "range changes none by more than its noise. Hold {} at a known value.",
            pave::join(names_of(space, u.directions.dead)), u.directions.dead.size() == 1 ? "it" : "them"));
    }
    if (!u.confirmation.empty()) {
        say(u.confirmation);
    }
    std::vector<std::string> wide;
    for (std::size_t k = 0; k < u.parameters.size(); ++k) {
        const Range& r = u.parameters[k];
        const problem::Axis& axis = space.axes[k];
        constexpr double half = 0.5;
        if (axis.unit(r.high) - axis.unit(r.low) > half) {
            wide.push_back(fmt::format("{} anywhere from {} to {}", axis.name, figure(r.low), figure(r.high)));
        }
    }
    if (!wide.empty()) {
        say(fmt::format("The data accept {}, if the others follow.", pave::join(wide)));
    }
    say(shape_words(result.problem, u));
    if (result.posterior) {
        for (std::string& words : posterior_words(study, *result.posterior)) {
            say(std::move(words));
        }
    }
    for (std::size_t o = 0; o < u.outputs.size(); ++o) {
        const Range& r = u.outputs[o];
        const data::Reading& output = study.readings[outputs[o]];
        const auto [low, high] =
            acceptance.widened ? widened({r.low, r.high}, result.outputs, outputs[o]) : std::pair(r.low, r.high);
        const bool is_wider = low < r.low || high > r.high;
        say(fmt::format("{} lies between {} and {} {} (95 %{}; best fit: {}).", output.output,
                        figure(output.in_unit(low)), figure(output.in_unit(high)), output.unit.name,
                        is_wider ? ", with what the model may lack" : "",
                        figure(output.in_unit(u.minima[0].evaluation.responses[outputs[o]]))));
    }
    if (u.traces.size() == 2) {
        std::vector<std::string> reach;
        double highest = 0.0;
        std::vector<std::vector<double>> ends;
        for (const Branch& trace : u.traces) {
            ends.push_back(trace.limit_unit);
            for (const auto& p : trace.points) {
                highest = std::max(highest, std::min(p.rise, acceptance.threshold));
            }
        }
        for (std::size_t k = 0; k < space.axes.size(); ++k) {
            if (std::abs(ends[0][k] - ends[1][k]) > 0.05) {
                reach.push_back(fmt::format("{} from {} to {}", space.axes[k].name,
                                            figure(space.axes[k].physical(ends[0][k])),
                                            figure(space.axes[k].physical(ends[1][k]))));
            }
        }
        say(fmt::format(
            "The valley was followed: {}, chi2 rising by {} at most (allowed: {}). One end: {}; the other: {}.",
            pave::join(reach), figure(highest), figure(acceptance.threshold),
            end_words(result.problem, u.traces[0].end, u.traces[0].on_bound, u.traces[0].on_limit),
            end_words(result.problem, u.traces[1].end, u.traces[1].on_bound, u.traces[1].on_limit)));
    }
    for (const auto& p : u.passes) {
        const bool joined = p.pass.rise < acceptance.threshold;
        say(fmt::format(
            "Minima {} and {}: {}.", p.a + 1, p.b + 1,
            !std::isfinite(p.pass.rise) ? "no way without a hole was found between them"
            : joined ? fmt::format("joined by a way on which chi2 rises by {} at most: one valley", figure(p.pass.rise))
                     : fmt::format("the lowest way found between them rises chi2 by {}", figure(p.pass.rise))));
    }
    say(limit_words(study));
    if (acceptance.widened) {
        say(fmt::format(
            "The model does not fit these data within their stated noise ({} = {} with {}, {}). The "
            "ranges are widened as if the noise were as large as the residuals, and rises of chi2 are counted in that "
            "noise: 1 of them is {} of the chi2 above. With a wrong model they can still mislead: diagnose looks for "
            "what "
            "it lacks.",
            result.problem.noise_is_student() ? "-2 ln likelihood" : "chi2", figure(acceptance.chi2),
            counted(static_cast<std::size_t>(std::max(0, acceptance.degrees_of_freedom)), "degree of freedom",
                    "degrees of freedom"),
            p_words(acceptance.p_value), figure(acceptance.variance)));
    } else if (study.noise == study::NoiseSource::sought) {
        say(fmt::format("{} chi2, counted in that noise, may rise by {} with {}.",
                        noise_scale_words(study, noise_scale_of(acceptance)), figure(acceptance.threshold),
                        counted(static_cast<std::size_t>(acceptance.degrees_of_freedom), "degree of freedom",
                                "degrees of freedom")));
    } else if (!acceptance.noise_is_stated) {
        say(fmt::format(
            "The data state no noise. It is estimated from the residuals of the fit, with only {}: chi2 may rise by "
            "{}. State it under [data.noise]: ranges get narrower, and a wrong model shows.",
            counted(static_cast<std::size_t>(acceptance.degrees_of_freedom), "degree of freedom", "degrees of freedom"),
            figure(acceptance.threshold)));
    }
    if (u.conflict && std::isfinite(u.conflict->p_value)) {
        const auto& c = *u.conflict;
        const std::vector<std::string> names = study.groups_fitted();
        if (c.p_value < 0.05) {
            const std::string wanted = conflict_words(space, c.direction);
            say(fmt::format("The groups of data contradict each other under this model ({}){}: fit shows "
                            "what each alone calls for, diagnose what the model may lack.",
                            p_words(c.p_value),
                            wanted.empty() ? ""
                                           : fmt::format("; {} calls for {} than {}", names[c.alone[c.second].group],
                                                         wanted, names[c.alone[c.first].group])));
        } else {
            say(fmt::format("The groups of data do not contradict each other ({}).", p_words(c.p_value)));
        }
    }
    if (!next.effects.empty() && u.verdict != Verdict::unique) {
        const auto& e = next.effects[0];
        const auto most =
            static_cast<std::size_t>(std::min_element(e.parameters.begin(), e.parameters.end()) - e.parameters.begin());
        const data::Reading& reading = next.candidates[e.candidate];
        std::string of_outputs;
        for (std::size_t o = 0; o < e.predictions.size(); ++o) {
            if (!std::isfinite(e.predictions[o])) { // of a load that was not computed
                continue;
            }
            of_outputs += fmt::format(", of the output {} to {:.0f} %", study.readings[outputs[o]].output,
                                      100.0 * e.predictions[o]);
        }
        say(fmt::format("Best next measurement: {} (noise {} {} assumed): the standard error of {} "
                        "falls to {:.0f} %{} of "
                        "what it is.",
                        reading.words(), figure(reading.in_unit(reading.noise.absolute)), reading.unit.name,
                        space.axes[most].name, 100.0 * e.parameters[most], of_outputs));
    }
    say(fmt::format(
        "{} independent starts in a row found no minimum that was not known before: at 95 % confidence the basins of "
        "attraction of any others make up less than {:.2g} % of the box. They may still exist.",
        u.unseen.since_new, 100.0 * u.unseen.volume_bound));
    if (result.landscape && result.landscape->profiled.lower_by > landscape::lower_matters) {
        say(fmt::format("The landscape over pairs of parameters met a set whose chi2 lies {} below that of the best "
                        "minimum: more searches (--verify) should find the minimum there.",
                        figure(result.landscape->profiled.lower_by)));
    }
    for (std::string& words : output_words(study, result.outputs)) {
        say(std::move(words));
    }
    say(mesh_words(study, result.mesh));
    say(path_words(study, result.path));
    if (study.external && !study.external->derivative_words().empty()) {
        say(study.external->derivative_words());
    }
    say(weights_words(study));
    say(noise_key_words(study));
    say(misfit_words(study));
    if (result.reduced) {
        say(model_words(result.options.model));
    }
    return text;
}

} // namespace explore::analysis
