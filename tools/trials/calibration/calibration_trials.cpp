// Are the program's statements of probability as often right as they say?
//
// ranks: simulation-based calibration (Talts et al. 2018, arXiv 1804.06788). Twins have parameters drawn from the prior
// of the study and readings drawn with its noise; the posterior of each is sampled, and 19 draws of it, evenly spread
// over all, are compared with the truth. The rank of the truth among them is uniform over 0 to 19 for every quantity if
// the sampler, the likelihood and the noise agree. Compared by the chi2 test with 20 bins.
//
// coverage: ranges of the parameters of fit and unique at the study's own values. A reading is the mean of three drops
// with the study's noise each. How often do ranges of 95 % hold the truth, with that noise stated, with the same
// standard deviations taken as independent, and with noise estimated from repeated drops? usage: calibration_trials
// ranks|coverage STUDY [--trials 500] [--samples 200] [--seed 1]
#include "analysis/survey/noise.h"
#include "base/random.h"
#include "landscape/acceptance.h"
#include "landscape/posterior.h"
#include "problem/student.h"
#include "run/blas.h"
#include "study/problems.h"

#include <CLI/CLI.hpp>
#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <atomic>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>
#include <oneapi/tbb.h>

namespace {

using namespace explore;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Options {
    std::string study;
    int trials = 500;
    int samples = 200;
    std::uint64_t seed = 1;
};

// Errors of the readings of one load of a drop, over their values [SI]: as the study states them, by the definition of
// data::Noise.
VectorXd drop_errors(const study::Study& study, const VectorXd& exact, const pave::RandomStream& random,
                     std::uint64_t first) {
    const Index n = exact.size();
    VectorXd own(n);
    MatrixXd rho = MatrixXd::Identity(n, n);
    VectorXd deviation(n);
    for (Index i = 0; i < n; ++i) {
        const auto& a = study.readings[static_cast<std::size_t>(i)];
        const auto k = first + static_cast<std::uint64_t>(i);
        own[i] = a.noise.degrees > 0.0
                     ? problem::student_draw(random.uniform(2 * k), random.uniform(2 * k + 1), a.noise.degrees)
                     : random.normal(k);
        deviation[i] = a.noise.own_deviation(exact[i]);
        for (Index j = 0; j < i; ++j) {
            const auto& b = study.readings[static_cast<std::size_t>(j)];
            const double length = a.noise.correlation_length;
            rho(i, j) = rho(j, i) = length > 0.0 ? std::exp(-std::abs(a.x_mm - b.x_mm) * 1e-3 / length) : 0.0;
        }
    }
    const VectorXd tied = rho.llt().matrixL() * own;
    const double common = random.normal(first + static_cast<std::uint64_t>(n));
    return deviation.cwiseProduct(tied) + study.readings[0].noise.common_relative * common * exact;
}

// The study with these readings [SI].
study::Study with_values(study::Study study, const VectorXd& values) {
    for (Index i = 0; i < values.size(); ++i) {
        auto& reading = study.readings[static_cast<std::size_t>(i)];
        reading.value = reading.in_unit(values[i]);
    }
    return study;
}

VectorXd measured_part(const study::Study& study, const std::vector<double>& responses) {
    return VectorXd::Map(responses.data(), static_cast<Index>(study.measured().size()));
}

void progress(std::atomic<int>& done, int all) {
    if (const int n = ++done; n % 25 == 0) {
        fmt::print(stderr, "{} of {}\n", n, all);
    }
}

// Quantities x trials; -1: no sample.
MatrixXd ranks_of(const study::Study& study, const Options& options, std::vector<std::string>& names) {
    constexpr std::size_t draws = 19;
    const auto outputs = study.outputs();
    for (const auto& axis : study.space.axes) {
        names.push_back(axis.name);
    }
    for (const std::size_t o : outputs) {
        names.push_back(study.readings[o].output);
    }
    MatrixXd ranks = MatrixXd::Constant(static_cast<Index>(names.size()), options.trials, -1.0);
    const problem::Problem as_stated = study::make_noise_problem(study, study::Scope::everything);
    std::atomic<int> done = 0;
    tbb::parallel_for(0, options.trials, [&](int trial) {
        const pave::RandomStream random(options.seed, static_cast<std::uint64_t>(trial));
        const auto workspace = as_stated.function->make_workspace();
        std::vector<double> unit;
        for (std::size_t k = 0; k < study.space.axes.size(); ++k) {
            const problem::Axis& axis = study.space.axes[k];
            const double u = random.uniform(2000 + k);
            if (!axis.prior) {
                unit.push_back(u);
                continue;
            }
            const double low = gsl_cdf_ugaussian_P(axis.pull(axis.low)); // normal, within the range
            const double high = gsl_cdf_ugaussian_P(axis.pull(axis.high));
            const double pull = gsl_cdf_ugaussian_Pinv(low + u * (high - low));
            unit.push_back(std::clamp((pull - axis.pull(axis.low)) / axis.d_pull(), 0.0, 1.0));
        }
        const auto truth = as_stated.evaluate(unit, false, *workspace);
        if (!truth.converged()) {
            return;
        }
        const VectorXd exact = measured_part(study, truth.responses);
        const study::Study twin = with_values(study, exact + drop_errors(study, exact, random, 0));
        const problem::Problem problem = study::make_noise_problem(twin, study::Scope::everything);
        run::Engine engine(problem, nullptr, 0, {.threads = 1, .show_progress = false});
        const int particles = 2 * (options.samples / 8);
        const auto posterior =
            landscape::posterior(engine, problem, {.populations = 4, .particles = particles, .most_last = 12},
                                 options.seed * 1000 + static_cast<std::uint64_t>(trial));
        if (!posterior || posterior->draws.empty()) {
            return;
        }
        VectorXd below = VectorXd::Zero(ranks.rows());
        for (std::size_t d = 0; d < draws; ++d) {
            const auto& draw = posterior->draws[(2 * d + 1) * posterior->draws.size() / (2 * draws)];
            for (std::size_t k = 0; k < unit.size(); ++k) {
                below[static_cast<Index>(k)] += draw.unit[k] < unit[k] ? 1.0 : 0.0;
            }
            for (std::size_t o = 0; o < outputs.size(); ++o) {
                below[static_cast<Index>(unit.size() + o)] +=
                    draw.responses[outputs[o]] < truth.responses[outputs[o]] ? 1.0 : 0.0;
            }
        }
        ranks.col(trial) = below;
        progress(done, options.trials);
    });
    return ranks;
}

int print_ranks(const study::Study& study, const Options& options) {
    constexpr int bins = 20;
    std::vector<std::string> names;
    const MatrixXd ranks = ranks_of(study, options, names);
    int status = 0;
    fmt::print("{:<28}{:>7}{:>9}{:>9}   ranks 0 to 19\n", "quantity", "twins", "chi2", "p");
    for (Index q = 0; q < ranks.rows(); ++q) {
        std::vector<int> count(bins, 0);
        int twins = 0;
        for (Index t = 0; t < ranks.cols(); ++t) {
            if (ranks(q, t) >= 0.0) {
                ++count[static_cast<std::size_t>(ranks(q, t))];
                ++twins;
            }
        }
        const double expected = twins / static_cast<double>(bins);
        double chi2 = 0.0;
        std::string list;
        for (const int c : count) {
            chi2 += (c - expected) * (c - expected) / expected;
            list += fmt::format(" {}", c);
        }
        const double p = gsl_cdf_chisq_Q(chi2, bins - 1);
        fmt::print("{:<28}{:>7}{:>9.1f}{:>9.3f}  {}\n", names[static_cast<std::size_t>(q)], twins, chi2, p, list);
        status = p < 0.001 ? 1 : status;
    }
    return status;
}

// The minimum from here, by Gauss-Newton steps that are halved until they help; held: an axis that stays, or -1.
landscape::Minimum minimum_from(const problem::Problem& problem, std::vector<double> unit, Index held,
                                problem::ForwardFunction::Workspace& workspace) {
    landscape::Minimum m;
    m.unit = std::move(unit);
    m.evaluation = problem.evaluate(m.unit, true, workspace);
    std::vector<Index> open;
    for (Index k = 0; k < static_cast<Index>(m.unit.size()); ++k) {
        if (k != held) {
            open.push_back(k);
        }
    }
    constexpr int most_rounds = 40;
    for (int round = 0; round < most_rounds && m.evaluation.converged(); ++round) {
        const MatrixXd j = problem.residual_jacobian(m.evaluation)(Eigen::all, open);
        const VectorXd step = -j.colPivHouseholderQr().solve(problem.residuals(m.evaluation));
        bool moved = false;
        double gain = 0.0;
        for (double share = 1.0; share > 1e-3 && !moved; share *= 0.5) {
            std::vector<double> there = m.unit;
            for (std::size_t i = 0; i < open.size(); ++i) {
                double& u = there[static_cast<std::size_t>(open[i])];
                u = std::clamp(u + share * step[static_cast<Index>(i)], 0.0, 1.0);
            }
            auto e = problem.evaluate(there, true, workspace);
            if (e.converged() && e.misfit < m.evaluation.misfit) {
                gain = std::pow(m.evaluation.misfit, 2) - std::pow(e.misfit, 2);
                m.unit = std::move(there);
                m.evaluation = std::move(e);
                moved = true;
            }
        }
        if (!moved || gain < 1e-6) {
            break;
        }
    }
    m.on_bound = landscape::bounds_met(m.unit);
    return m;
}

// What one way of stating the noise says.
struct Stated {
    std::string name;
    VectorXd by_error, by_profile; // trials that hold the truth, a parameter each
    int rejected = 0;              // p < 0.05
    int widened = 0;
    VectorXd width; // of every trial: mean of the widths by_error over the parameters, unit coordinates
};

// A mean of so many drops.
data::Noise of_mean(data::Noise noise, int drops) {
    const double root = std::sqrt(drops);
    noise.absolute /= root;
    noise.relative /= root;
    noise.common_relative /= root;
    return noise;
}

data::Noise noise_of(const analysis::NoiseModel& model) {
    using analysis::NoiseModel;
    return {.absolute = 1e-6 * model.value[NoiseModel::absolute],
            .relative = std::hypot(model.value[NoiseModel::relative], model.value[NoiseModel::common]),
            .common_relative = model.value[NoiseModel::common],
            .correlation_length = 1e-3 * model.value[NoiseModel::correlation]};
}

// The drops of a station as a file would hold them.
data::FwdStation station_of(const study::Study& study, const VectorXd& exact, const std::vector<VectorXd>& errors) {
    data::FwdStation station{.name = "twin", .lane = {}, .file = "twin"};
    int number = 0;
    for (const VectorXd& e : errors) {
        data::FwdDrop drop{.number = ++number, .radius_mm = 150.0, .pressure_kPa = 707.0, .readings = {}};
        for (Index i = 0; i < exact.size(); ++i) {
            drop.readings.push_back({study.readings[static_cast<std::size_t>(i)].x_mm, 1e6 * (exact[i] + e[i])});
        }
        station.drops.push_back(std::move(drop));
    }
    return station;
}

int print_coverage(const study::Study& study, const Options& options) {
    constexpr int drops = 3;
    constexpr int stations = 20;
    const auto parameters = static_cast<Index>(study.space.axes.size());
    const problem::Problem as_stated = study::make_noise_problem(study, study::Scope::everything);
    std::vector<double> own;
    for (const auto& axis : study.space.axes) {
        own.push_back(axis.unit(axis.start));
    }
    const auto truth = as_stated.evaluate(own, false, *as_stated.function->make_workspace());
    const VectorXd exact = measured_part(study, truth.responses);
    std::vector<Stated> results;
    for (const char* name : {"stated as it is", "taken as independent", "estimated, 3 drops of the station",
                             "estimated, 3 drops of 20 stations"}) {
        results.push_back({.name = name,
                           .by_error = VectorXd::Zero(parameters),
                           .by_profile = VectorXd::Zero(parameters),
                           .width = VectorXd::Zero(options.trials)});
    }
    std::mutex mutex;
    std::atomic<int> done = 0;
    tbb::parallel_for(0, options.trials, [&](int trial) {
        const pave::RandomStream random(options.seed, static_cast<std::uint64_t>(trial));
        std::vector<data::FwdFile> road(1);
        VectorXd mean = VectorXd::Zero(exact.size());
        for (int s = 0; s < stations; ++s) {
            std::vector<VectorXd> errors;
            for (int d = 0; d < drops; ++d) {
                errors.push_back(drop_errors(study, exact, random, 100 * static_cast<std::uint64_t>(s * drops + d)));
                mean += s == 0 ? VectorXd(errors.back() / drops) : VectorXd::Zero(exact.size());
            }
            road[0].stations.push_back(station_of(study, exact, errors));
        }
        data::FwdFile first;
        first.stations.push_back(road[0].stations[0]);
        const data::Noise estimates[] = {noise_of(analysis::noise_of_drops({first}).model),
                                         noise_of(analysis::noise_of_drops(road).model)};
        const auto workspace = as_stated.function->make_workspace();
        for (std::size_t way = 0; way < results.size(); ++way) {
            study::Study twin = with_values(study, exact + mean);
            for (std::size_t i = 0; i < static_cast<std::size_t>(exact.size()); ++i) {
                data::Noise& noise = twin.readings[i].noise;
                noise = of_mean(way >= 2 ? estimates[way - 2] : noise, drops);
                if (way == 1) {
                    noise.common_relative = noise.correlation_length = 0.0;
                }
            }
            const problem::Problem problem = study::make_noise_problem(twin, study::Scope::everything);
            const auto best = minimum_from(problem, own, -1, *workspace);
            const auto acceptance = landscape::acceptance_of(problem, best);
            const auto local = landscape::analyse(best, problem);
            VectorXd by_error = VectorXd::Zero(parameters);
            VectorXd by_profile = VectorXd::Zero(parameters);
            double width = 0.0;
            for (Index k = 0; k < parameters; ++k) {
                const auto i = static_cast<std::size_t>(k);
                const double half = std::sqrt(acceptance->threshold) * local.standard_error[i];
                by_error[k] = std::abs(best.unit[i] - own[i]) <= half ? 1.0 : 0.0;
                width += 2.0 * half / static_cast<double>(parameters);
                std::vector<double> start = best.unit;
                start[i] = own[i];
                const auto held = minimum_from(problem, start, k, *workspace);
                by_profile[k] =
                    acceptance->rise(held.evaluation.misfit, best.evaluation.misfit) <= acceptance->threshold ? 1.0
                                                                                                              : 0.0;
            }
            const std::scoped_lock lock(mutex); // sums of ones: the same in any order
            results[way].by_error += by_error;
            results[way].by_profile += by_profile;
            results[way].rejected += acceptance->p_value < 0.05 ? 1 : 0;
            results[way].widened += acceptance->widened ? 1 : 0;
            results[way].width[trial] = width;
        }
        progress(done, options.trials);
    });
    fmt::print("{} trials, readings are means of {} drops; ranges of 95 % that hold the truth\n", options.trials,
               drops);
    for (const Stated& r : results) {
        const auto percent = [&](double count) { return 100.0 * count / options.trials; };
        fmt::print("\n{}: p < 0.05 in {:.1f} %, widened {:.1f} %, mean width {:.3f} of the box\n", r.name,
                   percent(r.rejected), percent(r.widened), r.width.mean());
        for (Index k = 0; k < parameters; ++k) {
            fmt::print("  {:<28} by standard error {:5.1f} %   by profile {:5.1f} %\n",
                       study.space.axes[static_cast<std::size_t>(k)].name, percent(r.by_error[k]),
                       percent(r.by_profile[k]));
        }
    }
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app("Are statements of probability as often right as they say?");
    Options options;
    std::string what;
    app.add_option("WHAT", what, "ranks or coverage")->required()->check(CLI::IsMember({"ranks", "coverage"}));
    app.add_option("STUDY", options.study, "study file")->required();
    app.add_option("--trials", options.trials, "twins")->check(CLI::Range(20, 1'000'000))->capture_default_str();
    app.add_option("--samples", options.samples, "draws of a posterior")
        ->check(CLI::Range(80, 100'000))
        ->capture_default_str();
    app.add_option("--seed", options.seed)->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    try {
        run::prepare_blas();
        const study::Study study = study::load_study(options.study);
        return what == "ranks" ? print_ranks(study, options) : print_coverage(study, options);
    } catch (const std::exception& error) {
        fmt::print(stderr, "calibration_trials: {}\n", error.what());
        return 2;
    }
}
