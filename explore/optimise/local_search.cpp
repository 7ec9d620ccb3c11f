#include "optimise/local_search.h"

#include "optimise/gauss_newton.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlopt.hpp>

namespace explore::optimise {
namespace {

struct Known {
    Method method;
    std::optional<nlopt::algorithm> algorithm; // none: our own
};
constexpr Known known[] = {
    {{"gauss-newton", true, "damped Gauss-Newton steps in the box (Levenberg, Marquardt)"}, std::nullopt},
    {{"slsqp", true, "sequential quadratic programming (Kraft)"}, nlopt::LD_SLSQP},
    {{"lbfgs", true, "limited-memory BFGS (Luksan)"}, nlopt::LD_LBFGS},
    {{"mma", true, "method of moving asymptotes (Svanberg)"}, nlopt::LD_MMA},
    {{"tnewton", true, "preconditioned truncated Newton (Dembo, Steihaug)"}, nlopt::LD_TNEWTON_PRECOND_RESTART},
    {{"bobyqa", false, "quadratic models without derivatives (Powell)"}, nlopt::LN_BOBYQA},
    {{"cobyla", false, "linear models without derivatives (Powell)"}, nlopt::LN_COBYLA},
    {{"sbplx", false, "subspace simplex without derivatives (Rowan)"}, nlopt::LN_SBPLX},
};

// The state of one search as the callback sees it.
struct Search {
    const Objective& objective;
    nlopt::opt& optimiser;
    SearchResult result{};
    double best = std::numeric_limits<double>::infinity(); // half sum of squares
    double highest = 0.0;                                  // of the computed ones
    // The optimiser sees this times half the sum: a start far beyond a limit has slopes that its first step
    // would take at their word.
    double scale = 0.0;        // set by the first slope
    bool takes_limits = false; // as constraints of its own; else they are part of the sum
    Sample sample{};
    std::vector<double> asked{}; // where the sample is of
    Eigen::VectorXd origin{};    // of the optimiser's coordinates, with their metric; empty: they are those of the cube
    Eigen::MatrixXd metric{};
    Answer answer = Answer::no_answer;

    std::vector<double> unit_of(const std::vector<double>& x) const {
        if (metric.size() == 0) {
            return x;
        }
        const Eigen::VectorXd at =
            origin + metric * Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
        std::vector<double> unit(at.begin(), at.end());
        for (double& u : unit) {
            u = std::clamp(u, 0.0, 1.0);
        }
        return unit;
    }
    // By the optimiser's coordinates.
    Eigen::VectorXd moved_by(const Eigen::VectorXd& gradient) const {
        return metric.size() == 0 ? gradient : Eigen::VectorXd(metric.transpose() * gradient);
    }

    // The walls of the cube, each at most 0: unit - 1 and -unit.
    void walls(const std::vector<double>& x, double* values, double* gradients) const {
        const Eigen::VectorXd at =
            origin + metric * Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
        for (const double sign : {1.0, -1.0}) {
            for (Eigen::Index i = 0; i < at.size(); ++i) {
                *values++ = sign > 0.0 ? at[i] - 1.0 : -at[i];
                for (Eigen::Index k = 0; gradients != nullptr && k < at.size(); ++k) {
                    *gradients++ = sign * metric(i, k);
                }
            }
        }
    }

    static void walls_callback(unsigned /*count*/, double* values, unsigned n, const double* x, double* gradients,
                               void* self) {
        static_cast<const Search*>(self)->walls({x, x + n}, values, gradients);
    }

    // x: of the cube, as below.
    Answer ask(const std::vector<double>& x) {
        if (x != asked) {
            ++result.evaluations;
            answer = objective(x, sample);
            asked = x;
        }
        return answer;
    }

    // The limits, each at most 0, and their derivatives by row.
    void limits(const std::vector<double>& x, double* values, double* gradients) {
        const auto count = sample.limits.size();
        const bool computed = ask(unit_of(x)) == Answer::computed;
        for (Eigen::Index i = 0; i < count; ++i) {
            values[i] = computed ? sample.limits[i] : 0.0;
            if (gradients == nullptr) {
                continue;
            }
            const Eigen::VectorXd slope = computed ? moved_by(sample.limit_jacobian.row(i).transpose())
                                                   : Eigen::VectorXd::Zero(static_cast<Eigen::Index>(x.size()));
            gradients = std::copy(slope.begin(), slope.end(), gradients);
        }
    }

    static void limits_callback(unsigned /*count*/, double* values, unsigned n, const double* x, double* gradients,
                                void* self) {
        static_cast<Search*>(self)->limits({x, x + n}, values, gradients);
    }

    // z: of the optimiser.
    double value(const std::vector<double>& z, std::vector<double>& gradient) {
        const std::vector<double> x = unit_of(z);
        ask(x);
        if (answer == Answer::computed) {
            const double half = 0.5 * sample.residuals.squaredNorm();
            if (std::isfinite(half)) {
                if (half < best) {
                    best = half;
                    result.unit = x;
                }
                highest = std::max(highest, half);
                if (!gradient.empty()) {
                    Eigen::VectorXd g = sample.jacobian.transpose() * sample.residuals;
                    if (takes_limits) {
                        g -= sample.limit_jacobian.transpose() * sample.limits.cwiseMax(0.0);
                    }
                    if (scale == 0.0 && metric.size() > 0) { // the rows' own curvature is then 1 at most
                        const double most = (sample.jacobian * metric).colwise().squaredNorm().maxCoeff();
                        scale = most > 0.0 ? 1.0 / most : 1.0;
                    }
                    if (scale == 0.0) {
                        constexpr double steep = 1e7;
                        scale = g.norm() > steep ? 1.0 / g.norm() : 1.0;
                    }
                    const Eigen::VectorXd scaled = scale * moved_by(g);
                    std::copy(scaled.begin(), scaled.end(), gradient.begin());
                }
                const double seen = takes_limits ? half - 0.5 * sample.limits.cwiseMax(0.0).squaredNorm() : half;
                return scale > 0.0 ? scale * seen : seen;
            }
        }
        if (answer == Answer::stop) {
            result.stopped = true;
            optimiser.force_stop();
        }
        // A bounded barrier: higher than anything computed, sloping up away from the best point.
        const double base = (scale > 0.0 ? scale : 1.0) * (2.0 * highest + 1e-6);
        Eigen::VectorXd d = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(x.size()));
        for (std::size_t k = 0; k < x.size(); ++k) {
            d[static_cast<Eigen::Index>(k)] = result.unit.empty() ? 0.0 : x[k] - result.unit[k];
        }
        if (!gradient.empty()) {
            const Eigen::VectorXd away = 2.0 * base * moved_by(d);
            std::copy(away.begin(), away.end(), gradient.begin());
        }
        return base * (1.0 + d.squaredNorm());
    }

    static double callback(const std::vector<double>& x, std::vector<double>& gradient, void* self) {
        return static_cast<Search*>(self)->value(x, gradient);
    }
};

std::string in_words(nlopt::result code) {
    switch (code) {
    case nlopt::SUCCESS: return "converged";
    case nlopt::STOPVAL_REACHED: return "an exact fit";
    case nlopt::FTOL_REACHED: return "the misfit no longer changes";
    case nlopt::XTOL_REACHED: return "the parameters no longer change";
    case nlopt::MAXEVAL_REACHED: return "the limit of evaluations";
    case nlopt::ROUNDOFF_LIMITED: return "rounding limits further progress";
    case nlopt::FORCED_STOP: return "stopped";
    default: return "the method gave up";
    }
}

} // namespace

std::span<const Method> methods() {
    static const std::vector<Method> all = [] {
        std::vector<Method> list;
        for (const Known& k : known) {
            list.push_back(k.method);
        }
        return list;
    }();
    return all;
}

const Method* find_method(std::string_view name) {
    for (const Method& method : methods()) {
        if (method.name == name) {
            return &method;
        }
    }
    return nullptr;
}

SearchResult local_search(const Method& method, const std::vector<double>& start, const Objective& objective,
                          const SearchSettings& settings) {
    std::optional<nlopt::algorithm> algorithm;
    for (const Known& k : known) {
        algorithm = k.method.name == method.name ? k.algorithm : algorithm;
    }
    if (!algorithm) {
        return gauss_newton(start, objective, settings);
    }
    nlopt::opt optimiser(*algorithm, static_cast<unsigned>(start.size()));
    Search search{.objective = objective, .optimiser = optimiser};
    std::vector<double> x = start;
    if (*algorithm == nlopt::LD_SLSQP && settings.metric.size() > 0) {
        search.origin = Eigen::Map<const Eigen::VectorXd>(start.data(), static_cast<Eigen::Index>(start.size()));
        search.metric = settings.metric;
        x.assign(start.size(), 0.0);
        constexpr double met = 1e-12;
        optimiser.add_inequality_mconstraint(&Search::walls_callback, &search,
                                             std::vector<double>(2 * start.size(), met));
    } else {
        optimiser.set_lower_bounds(0.0);
        optimiser.set_upper_bounds(1.0);
    }
    optimiser.set_min_objective(&Search::callback, &search);
    optimiser.set_maxeval(settings.max_evaluations);
    optimiser.set_xtol_abs(settings.step_tolerance);
    optimiser.set_ftol_rel(settings.misfit_tolerance);
    optimiser.set_stopval(1e-24);
    const bool constrains = *algorithm == nlopt::LD_SLSQP || *algorithm == nlopt::LN_COBYLA;
    if (constrains && search.ask(start) == Answer::computed && search.sample.limits.size() > 0) {
        search.takes_limits = true;
        constexpr double met = 1e-3; // of the tolerance of a limit
        optimiser.add_inequality_mconstraint(&Search::limits_callback, &search,
                                             std::vector<double>(search.sample.limits.size(), met));
    }
    if (!method.uses_gradient) {
        optimiser.set_initial_step(0.1);
    }
    double value = 0.0;
    nlopt::result code = nlopt::FAILURE;
    try {
        code = optimiser.optimize(x, value);
    } catch (const nlopt::roundoff_limited&) {
        code = nlopt::ROUNDOFF_LIMITED;
    } catch (const nlopt::forced_stop&) {
        code = nlopt::FORCED_STOP;
    } catch (const std::runtime_error&) {
        code = nlopt::FAILURE;
    }
    search.result.misfit = std::sqrt(2.0 * search.best);
    search.result.converged = code == nlopt::SUCCESS || code == nlopt::FTOL_REACHED || code == nlopt::XTOL_REACHED ||
                              code == nlopt::STOPVAL_REACHED || code == nlopt::ROUNDOFF_LIMITED;
    search.result.ended = in_words(code);
    return search.result;
}

} // namespace explore::optimise
