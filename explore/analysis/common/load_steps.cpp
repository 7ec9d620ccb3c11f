#include "analysis/common/load_steps.h"

#include "analysis/common/say.h"
#include "landscape/multistart.h"
#include "pavement/forward.h"
#include "run/parallel.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>

namespace explore::analysis {
namespace {

constexpr double allowed = 0.1;                   // of the noise
constexpr double unseen = 0.02;                   // of the noise: fewer than the default leave no more
constexpr double order = 3.0;                     // of the path in its steps
constexpr double whole_of_difference = 8.0 / 7.0; // error in n steps, by the difference to 2 n
constexpr int default_steps = pave::fe::SolverSettings{}.load_steps;
constexpr int fewest_steps = 5;
constexpr int most_steps = 3 * default_steps;

// So many steps or more, such that what leaves this share of the noise leaves the other.
int enough(int steps, double share, double wanted) {
    return std::max(steps, static_cast<int>(std::ceil(steps * std::pow(share / wanted, 1.0 / order))));
}

// The number of steps for a noise. share_in(n, wanted): the largest error in n steps as a share of the noise, scaled so
// that it is to be `wanted` where an answer is expected and a tenth elsewhere; nothing: it is known nowhere.
template <class ShareIn>
int steps_for(ShareIn share_in) {
    const std::optional<double> in_few = share_in(fewest_steps, unseen);
    if (!in_few) {
        return default_steps;
    }
    if (const int few = enough(fewest_steps, *in_few, unseen); few <= default_steps) {
        return few;
    }
    const std::optional<double> in_default = share_in(default_steps, allowed);
    return in_default ? std::min(enough(default_steps, *in_default, allowed), most_steps) : default_steps;
}

// Whether a load at rest is followed step by step.
bool integrates_load(const pave::pavement::Case& model) {
    const bool has_law = std::any_of(model.layers.begin(), model.layers.end(),
                                     [](const auto& layer) { return layer.law->stress_dependent(); });
    return has_law && !model.is_hyperelastic() && !model.relaxes() &&
           model.settings.integration == pave::pavement::Integration::incremental;
}

study::Study with_steps(study::Study study, int steps) {
    study.model.settings.solver.load_steps = steps;
    return study;
}

// Points where a fit may end: of a sample of the box those with the smallest misfit, and last the end of a search.
std::vector<problem::Evaluation> likely_answers(const study::Study& study, const problem::Problem& problem,
                                                const Session& session) {
    constexpr int sample = 32;
    constexpr std::size_t best = 4;
    run::Engine engine(problem, nullptr, 0, {.threads = session.options().threads, .show_progress = false});
    landscape::MultistartSettings settings{.starts = 1};
    settings.search.max_evaluations = 12;
    auto found = landscape::multistart(engine, problem, search::sobol(study.space, sample, 1), settings);
    if (!found || found->minima.empty()) {
        return {};
    }
    std::vector<problem::Evaluation> points = std::move(found->explored);
    std::erase_if(points, [](const problem::Evaluation& e) { return !e.converged(); });
    std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.misfit < b.misfit; });
    points.resize(std::min(points.size(), best));
    points.push_back(std::move(found->minima[0].evaluation));
    return points;
}

// "": no more than 1 %, no load path, or no answer in twice the steps.
std::string path_warning(const study::Study& study, const pave::pavement::Case& at, const std::vector<double>& values) {
    const int steps = at.settings.solver.load_steps;
    const auto is_followed = [&](std::size_t i) {
        const pave::pavement::Load& load = at.loads[static_cast<std::size_t>(at.sensors[i].load)];
        return load.is_axisymmetric() && !load.is_pulse();
    };
    std::vector<std::size_t> followed;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (is_followed(i)) {
            followed.push_back(i);
        }
    }
    if (followed.empty() || !integrates_load(at)) {
        return "";
    }
    pave::pavement::Case fine = at;
    fine.settings.solver.load_steps = 2 * steps;
    const pave::pavement::ForwardModel model(fine);
    const auto other = model.run(model.nominal(), {}, *model.make_workspace());
    if (!other) {
        return "";
    }
    std::map<pave::pavement::Quantity, double> largest;
    for (std::size_t i = 0; i < values.size(); ++i) {
        double& own = largest[at.sensors[i].quantity];
        own = std::max(own, std::abs(values[i]));
    }
    constexpr double small = 0.1;
    double most = 0.0;
    std::size_t reading = 0;
    for (const std::size_t i : followed) {
        const double scale = std::max(std::abs(values[i]), small * largest[at.sensors[i].quantity]);
        const double share = scale > 0.0 ? whole_of_difference * std::abs(other->values[i] - values[i]) / scale : 0.0;
        if (share > most) {
            most = share;
            reading = i;
        }
    }
    constexpr double said = 0.01;
    constexpr double wanted = 0.002;
    return most < said ? ""
                       : fmt::format("The {} load steps leave an error of about {:.0f} % in {}: load_steps = {} under "
                                     "[solver] leaves some {:g} %.",
                                     steps, 100.0 * most, study.readings[reading].words(),
                                     analysis::enough(steps, most, wanted), 100.0 * wanted);
}

} // namespace

bool PathError::shows() const {
    return share > allowed;
}

int PathError::enough() const {
    return analysis::enough(steps, share, allowed);
}

bool follows_load_path(const study::Study& study) {
    const auto& model = study.model;
    if (!integrates_load(model)) {
        return false;
    }
    const std::vector<bool> fitted = study::fitted_loads(study);
    for (std::size_t l = 0; l < fitted.size(); ++l) {
        if (fitted[l] && !model.loads[l].is_pulse()) {
            return true;
        }
    }
    return false;
}

std::optional<PathError> path_error(const study::Study& study, const problem::Problem& problem,
                                    const problem::Evaluation& answer, double noise) {
    if (!(noise > 0.0) || !follows_load_path(study)) {
        return std::nullopt;
    }
    const int steps = study.model.settings.solver.load_steps;
    const problem::Problem finer = study::make_problem(with_steps(study, 2 * steps), study::Scope::fitted);
    const auto outcome = finer.function->evaluate(answer.parameters, false, *finer.function->make_workspace());
    if (!outcome) {
        return std::nullopt;
    }
    problem::Evaluation other = answer;
    other.responses = outcome->responses;
    const Eigen::VectorXd shares =
        whole_of_difference * (problem.single_residuals(answer) - problem.single_residuals(other)).cwiseAbs() / noise;
    PathError error{.steps = steps};
    Eigen::Index most = 0;
    error.share = shares.maxCoeff(&most);
    if (!std::isfinite(error.share)) {
        return std::nullopt;
    }
    error.reading = problem.response_of(static_cast<std::size_t>(most));
    error.change = whole_of_difference * (answer.responses[error.reading] / other.responses[error.reading] - 1.0);
    return error;
}

study::Study with_enough_load_steps(study::Study study, const Session& session) {
    if (study.load_steps != study::LoadSteps::by_default || study.parameters.empty() || !follows_load_path(study)) {
        return study;
    }
    const study::Study coarse = with_steps(study, fewest_steps);
    const problem::Problem problem = study::make_noise_problem(coarse, study::Scope::fitted);
    if (!problem.noise_is_stated()) {
        return study;
    }
    const std::vector<problem::Evaluation> points = likely_answers(coarse, problem, session);
    tbb::task_arena arena(run::usable_threads(session.options().threads));
    const int steps = steps_for([&](int n, double wanted) {
        const study::Study followed = with_steps(study, n);
        const problem::Problem in_n = study::make_noise_problem(followed, study::Scope::fitted);
        std::vector<std::optional<double>> shares(points.size());
        run::for_each_index(arena, points.size(), [&](std::size_t i) {
            const auto outcome = in_n.function->evaluate(points[i].parameters, false, *in_n.function->make_workspace());
            if (outcome) {
                problem::Evaluation there = points[i];
                there.responses = outcome->responses;
                if (const auto error = path_error(followed, in_n, there, 1.0)) {
                    shares[i] = error->share * (i + 1 == points.size() ? 1.0 : wanted / allowed);
                }
            }
        });
        return shares.empty() ? std::nullopt : *std::max_element(shares.begin(), shares.end()); // nothing is the least
    });
    study.load_steps = study::LoadSteps::chosen;
    study.model.settings.solver.load_steps = steps;
    return study;
}

study::Study with_enough_load_steps(study::Study study, double relative_noise) {
    if (study.load_steps != study::LoadSteps::by_default || !(relative_noise > 0.0) || !follows_load_path(study)) {
        return study;
    }
    const auto values_in = [&](int steps) {
        const pave::pavement::ForwardModel model(with_steps(study, steps).model);
        const auto response = model.run(model.nominal(), {}, *model.make_workspace());
        return response ? response->values : std::vector<double>();
    };
    const int steps = steps_for([&](int n, double) {
        const std::vector<double> coarse = values_in(n);
        const std::vector<double> fine = values_in(2 * n);
        std::optional<double> share;
        for (std::size_t i = 0; i < std::min(coarse.size(), fine.size()) && i < study.measured().size(); ++i) {
            const double change = whole_of_difference * std::abs(coarse[i] / fine[i] - 1.0);
            share = std::max(share, std::isfinite(change) ? std::optional(change / relative_noise) : std::nullopt);
        }
        return share;
    });
    study.load_steps = study::LoadSteps::chosen;
    study.model.settings.solver.load_steps = steps;
    return study;
}

pave::Outcome<pave::pavement::Response> with_path_warning(const study::Study& study, const pave::pavement::Case& at,
                                                          pave::Outcome<pave::pavement::Response> outcome) {
    if (!outcome || study.has_own_model) {
        return outcome;
    }
    pave::pavement::Response response = std::move(outcome).value();
    say(response.warnings, path_warning(study, at, response.values));
    return response;
}

std::string path_words(const study::Study& study, const std::optional<PathError>& error) {
    if (error && error->shows()) {
        return fmt::format(
            "The load path is followed in {} steps, which leave an error of {:.2g} % in {}: {:.2g} of its "
            "noise. load_steps = {} under [solver] leaves a tenth.",
            error->steps, 100.0 * std::abs(error->change), study.readings[error->reading].words(), error->share,
            error->enough());
    }
    const int steps = study.model.settings.solver.load_steps;
    if (study.load_steps != study::LoadSteps::chosen || steps <= default_steps) {
        return "";
    }
    return fmt::format("Load paths are followed in {} steps instead of {}: fewer would leave more than a tenth of the "
                       "noise in a reading.",
                       steps, default_steps);
}

} // namespace explore::analysis
