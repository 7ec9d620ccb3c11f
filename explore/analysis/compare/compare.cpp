#include "analysis/compare/compare.h"

#include "analysis/common/groups.h"
#include "analysis/common/layout.h"
#include "analysis/common/load_steps.h"
#include "analysis/sample/sample.h"
#include "base/error.h"
#include "base/text.h"
#include "landscape/goodness.h"
#include "material/catalog.h"
#include "run/interrupt.h"
#include "study/laws.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {
namespace {

using landscape::Uniqueness;
using pave::material::Law;

std::size_t layer_of(const study::Study& study, const std::string& name) {
    std::vector<std::string> names;
    for (const auto& layer : study.model.layers) {
        names.push_back(layer.name);
    }
    if (!name.empty()) {
        const auto found = std::find(names.begin(), names.end(), name);
        if (found == names.end()) {
            throw pave::Error({.key = "--layer"}, "the study has no such layer", "\"" + name + "\"", pave::join(names));
        }
        return static_cast<std::size_t>(found - names.begin());
    }
    const auto layers = study::stress_dependent_layers(study);
    if (layers.size() != 1) {
        throw pave::Error(
            {.file = study.file, .key = "--layer"}, "which layer's law is in question?",
            pave::counted(layers.size(), "layer whose law depends on stress", "layers whose law depends on stress"),
            pave::join(names));
    }
    return layers[0];
}

std::vector<const Law*> laws_of(const CompareOptions& options) {
    std::vector<std::string> names;
    for (const Law* law : pave::material::laws()) {
        names.emplace_back(law->name());
    }
    std::vector<const Law*> laws;
    for (const std::string& name : options.laws.empty() ? names : options.laws) {
        const Law* law = pave::material::find_law(name);
        if (law == nullptr) {
            const std::string near = pave::nearest_name(name, names);
            throw pave::Error({.key = "--laws"},
                              "unknown law" + (near.empty() ? "" : ", did you mean \"" + near + "\"?"),
                              "\"" + name + "\"", pave::join(names));
        }
        if (std::find(laws.begin(), laws.end(), law) == laws.end()) {
            laws.push_back(law);
        }
    }
    return laws;
}

// The readings of every place predicted by a fit without them, from the best of what was explored and from the best
// minimum. Nothing: interrupted, or no fold has an answer.
std::optional<double> left_out_rms(const problem::Problem& problem, run::Engine& engine, const Layout& layout,
                                   const Uniqueness& answer) {
    // Fewer readings than parameters predict anything.
    const int free = problem.degrees_of_freedom(problem.space.axes.size());
    if (std::any_of(layout.places.begin(), layout.places.end(),
                    [&](const diagnose::Fold& fold) { return static_cast<int>(fold.terms.size()) > free; })) {
        return std::nullopt;
    }
    std::vector<double> squares(layout.places.size(), 0.0);
    std::vector<std::size_t> counts(layout.places.size(), 0);
    const bool done = engine.chains(
        "places left out", landscape::first_start_of_others, layout.places.size(),
        [&](std::size_t f, run::Chain& chain) {
            const auto& fold = layout.places[f];
            const diagnose::Target target = diagnose::leaving_out(fold.terms, problem.rows());
            const problem::Evaluation* nearest = &answer.minima[0].evaluation;
            double lowest = std::numeric_limits<double>::infinity();
            for (const auto& e : answer.explored) {
                if (const double sum = e.converged() ? diagnose::counted_sum(problem.residuals(e), target) : lowest;
                    sum < lowest) {
                    lowest = sum;
                    nearest = &e;
                }
            }
            std::optional<diagnose::Model> best;
            for (const auto& start : {problem.space.unit(nearest->parameters), answer.minima[0].unit}) {
                auto model = diagnose::fit(chain, problem, {}, start, target, {});
                if (model && (!best || model->sum < best->sum)) {
                    best = std::move(model);
                }
            }
            if (best) {
                for (const std::size_t i : fold.terms) {
                    squares[f] += std::pow(best->residuals[static_cast<Eigen::Index>(i)], 2);
                    ++counts[f];
                }
            }
        });
    std::size_t count = 0;
    double sum = 0.0;
    for (std::size_t f = 0; f < squares.size(); ++f) {
        count += counts[f];
        sum += squares[f];
    }
    return done && count > 0 ? std::optional(std::sqrt(sum / static_cast<double>(count))) : std::nullopt;
}

// False: interrupted.
bool fit_law(Session& session, FittedLaw& f, const CompareOptions& options, const std::string& settings) {
    const study::Study& study = f.study;
    const problem::Problem fitted = study::make_noise_problem(study, study::Scope::fitted);
    const problem::Problem everything = study::make_noise_problem(study, study::Scope::everything);
    auto everything_engine = session.engine(everything, session.begin(study, "compare-outputs", settings));
    auto engine = session.engine(fitted, session.begin(study, "compare", settings));
    auto answer = landscape::uniqueness(
        uniqueness_task(study, fitted, everything, engine, everything_engine, session.options().seed),
        options.settings);
    if (!answer) {
        return false;
    }
    f.answer = std::move(*answer);
    if (f.answer.minima.empty()) {
        f.failed = run::why_no_minimum(fitted, f.answer.explored);
        return true;
    }
    f.best = f.answer.minima[0].evaluation;
    Predictor(study).complete(f.best);
    const std::size_t parameters = study.space.axes.size();
    f.misfit = study::make_problem(study, study::Scope::fitted).misfit(f.best);
    f.chi2 = fitted.residuals(f.best).squaredNorm();
    f.dof = fitted.degrees_of_freedom(parameters - f.answer.directions.flat.size());
    if (fitted.noise_is_stated() && f.dof > 0) {
        f.p_value = landscape::goodness_of(fitted, f.best, f.chi2, f.dof).p_value;
    }
    f.aicc = diagnose::aicc(f.chi2, fitted.readings(), parameters, fitted.noise_is_stated());
    f.study_holds = held_out_rms(study, f.best.responses);
    f.group_rms = group_rms(study, f.best);
    f.by_place = left_out_rms(fitted, engine, layout_of(study), f.answer);
    return f.by_place.has_value() || !run::interrupted();
}

// False: interrupted.
bool sample_law(Session& session, FittedLaw& f) {
    const auto sampled = sample(session, f.study, {});
    if (!sampled) {
        return false;
    }
    if (!sampled->failed()) {
        f.evidence = {.log = sampled->log_evidence,
                      .error = sampled->log_evidence_error,
                      .missing = sampled->missing.empty() ? "" : sampled->reason()};
    }
    return true;
}

void weigh_evidence(std::vector<FittedLaw>& laws) {
    double most = -std::numeric_limits<double>::infinity();
    for (const FittedLaw& f : laws) {
        most = f.evidence ? std::max(most, f.evidence->log) : most;
    }
    double sum = 0.0;
    for (FittedLaw& f : laws) {
        if (f.evidence) {
            f.evidence->weight = std::exp(f.evidence->log - most);
            sum += f.evidence->weight;
        }
    }
    for (FittedLaw& f : laws) {
        if (f.evidence) {
            f.evidence->weight /= sum;
        }
    }
}

void weigh(std::vector<FittedLaw>& laws) {
    double least = std::numeric_limits<double>::infinity();
    for (const FittedLaw& f : laws) {
        least = f.failed.empty() ? std::min(least, f.aicc) : least;
    }
    double sum = 0.0;
    for (FittedLaw& f : laws) {
        f.weight = f.failed.empty() && std::isfinite(f.aicc) ? std::exp(-(f.aicc - least) / 2.0) : 0.0;
        sum += f.weight;
    }
    for (FittedLaw& f : laws) {
        f.weight = sum > 0.0 ? f.weight / sum : 0.0;
    }
    std::stable_sort(laws.begin(), laws.end(), [](const FittedLaw& a, const FittedLaw& b) {
        return a.failed.empty() != b.failed.empty() ? a.failed.empty()
               : a.aicc != b.aicc                   ? a.aicc < b.aicc
                                                    : a.chi2 < b.chi2;
    });
}

// Fits and samples all of them; the one that is preferred becomes the run used last. False: interrupted.
bool fit_all(Session& session, CompareResult& result, const CompareOptions& options) {
    const std::string settings =
        fmt::format("searches of {} evaluations, seed {}", options.settings.max_evaluations, session.options().seed);
    for (FittedLaw& f : result.laws) {
        if (!fit_law(session, f, options, settings)) {
            return false;
        }
    }
    for (FittedLaw& f : result.laws) {
        if (options.evidence && f.failed.empty() && !sample_law(session, f)) {
            return false;
        }
        if (!result.same_noise) {
            f.aicc = std::numeric_limits<double>::quiet_NaN();
        }
    }
    weigh_evidence(result.laws);
    weigh(result.laws);
    session.begin(result.laws[0].study, "compare", settings);
    return true;
}

// The readings that a study fits.
std::vector<const data::Reading*> fitted_readings(const study::Study& study) {
    std::vector<const data::Reading*> readings;
    for (const study::Group& group : study.groups) {
        for (const std::size_t row : group.rows) {
            if (!group.held_out) {
                readings.push_back(&study.readings[row]);
            }
        }
    }
    return readings;
}

bool is_same_reading(const data::Reading& a, const data::Reading& b) {
    const double largest = std::max(std::abs(a.measured()), std::abs(b.measured()));
    constexpr double rounding = 1e-9; // of the unit
    return a.load == b.load && a.quantity == b.quantity && a.x_mm == b.x_mm && a.y_mm == b.y_mm &&
           a.depth_mm == b.depth_mm && a.gauge_mm == b.gauge_mm && a.time_ms == b.time_ms && a.censored == b.censored &&
           std::abs(a.measured() - b.measured()) <= rounding * largest;
}

bool is_same_noise(const data::Reading& a, const data::Reading& b) {
    const data::Noise& n = a.noise;
    const data::Noise& m = b.noise;
    constexpr double rounding = 1e-9;
    return std::abs(n.deviation(a.measured()) - m.deviation(b.measured())) <= rounding * n.deviation(a.measured()) &&
           n.relative == m.relative && n.common_relative == m.common_relative &&
           n.correlation_length == m.correlation_length && n.correlation_time == m.correlation_time &&
           n.drift == m.drift && n.degrees == m.degrees && n.scale_is_sought == m.scale_is_sought;
}

// Whether the noise of the readings is the same, too. Throws where the readings are not.
bool have_same_noise(const study::Study& first, const study::Study& other) {
    const auto readings = fitted_readings(first);
    std::vector<const data::Reading*> left = fitted_readings(other);
    bool same = first.noise == other.noise;
    for (const data::Reading* reading : readings) {
        const auto found =
            std::find_if(left.begin(), left.end(), [&](const auto* r) { return is_same_reading(*r, *reading); });
        if (found == left.end()) {
            throw pave::Error({.file = reading->file, .line = reading->line},
                              "studies are compared by the same readings; this one is not fitted in " + other.file,
                              fmt::format("{} = {} {}", reading->words(), reading->value, reading->unit.name),
                              fmt::format("the same readings in both: {} has {}, {} has {}", first.file,
                                          readings.size(), other.file, fitted_readings(other).size()));
        }
        same = same && is_same_noise(*reading, **found);
        left.erase(found);
    }
    if (!left.empty()) {
        throw pave::Error({.file = left[0]->file, .line = left[0]->line},
                          "studies are compared by the same readings; this one is not fitted in " + first.file,
                          fmt::format("{} = {} {}", left[0]->words(), left[0]->value, left[0]->unit.name),
                          "the same readings in both");
    }
    return same;
}

} // namespace

std::optional<CompareResult> compare(Session& session, const study::Study& study, const CompareOptions& options) {
    const auto begin = std::chrono::steady_clock::now();
    study::refuse_own_model(study, "compare with laws");
    study::make_problem(study, study::Scope::fitted); // complains of what is missing
    if (options.evidence) {
        check_noise_for_sample(study);
    }
    const std::size_t layer = layer_of(study, options.layer);
    CompareResult result{.study = study, .layer = study.model.layers[layer].name, .laws = {}};
    for (const Law* law : laws_of(options)) {
        study::Study with_law = study::with_law(study, layer, *law, {.file = study.file, .key = "--laws"});
        result.laws.push_back({.law = law, .study = with_enough_load_steps(std::move(with_law), session)});
    }
    if (!fit_all(session, result, options)) {
        return std::nullopt;
    }
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return result;
}

std::optional<CompareResult> compare_studies(Session& session, const std::vector<study::Study>& studies,
                                             const CompareOptions& asked) {
    const auto begin = std::chrono::steady_clock::now();
    CompareResult result{.study = studies[0], .layer = {}, .laws = {}};
    CompareOptions options = asked;
    options.evidence = true;
    for (std::size_t i = 0; i < studies.size(); ++i) {
        const study::Study& study = studies[i];
        if (std::any_of(studies.begin(), studies.begin() + static_cast<std::ptrdiff_t>(i),
                        [&](const study::Study& other) { return other.file == study.file; })) {
            throw pave::Error({.file = study.file, .key = "STUDY"}, "this study is compared with itself", {},
                              "studies that differ");
        }
        study::make_problem(study, study::Scope::fitted);
        result.same_noise = result.same_noise && have_same_noise(studies[0], study);
        options.evidence = options.evidence && study.noise == study::NoiseSource::stated && study.noise_assumed == 0;
        result.laws.push_back({.law = nullptr, .study = with_enough_load_steps(study, session)});
    }
    if (!fit_all(session, result, options)) {
        return std::nullopt;
    }
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return result;
}

} // namespace explore::analysis
