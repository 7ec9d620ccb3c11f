#include "diagnose/simulated_data.h"

#include "base/random.h"
#include "run/parallel.h"
#include "run/progress.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace explore::diagnose {
namespace {

class Simulation {
public:
    Simulation(const DiagnosisTask& task, const Diagnosis& d, const SimulationSettings& settings)
        : task_(task),
          d_(d),
          settings_(settings),
          leading_(d.effects[0]),
          screened_(d.screening.items[leading_.candidate]),
          members_(leading_.fit->model.members) {}

    // The gain by the effect in each, where both fits have an answer; nothing: interrupted.
    std::optional<std::vector<double>> gains() {
        if (!start()) {
            return std::nullopt;
        }
        constexpr int few = 10; // where they leave no doubt, the rest is saved
        tbb::task_arena arena(run::concurrency(task_.bench.threads()));
        run::Progress progress("simulated data", settings_.simulations);
        std::vector<double> gains;
        int tried = 0;
        while (tried < settings_.simulations) {
            const int more = tried == 0 ? std::min(few, settings_.simulations) : settings_.simulations - tried;
            std::vector<std::optional<double>> drawn(static_cast<std::size_t>(more));
            run::for_each_index(arena, drawn.size(), [&](std::size_t i) {
                drawn[i] = gain_by_chance(static_cast<std::size_t>(tried) + i);
                progress.add(1, true);
            });
            if (run::interrupted()) {
                return std::nullopt;
            }
            tried += more;
            for (const auto& gain : drawn) {
                if (gain) {
                    gains.push_back(*gain);
                }
            }
            if (tried == few && !leave_doubt(gains)) {
                break;
            }
        }
        return gains;
    }

    // Mean gain by chance, so many of its standard errors more, in units of what linear theory expects; at least 1.
    double bartlett(const std::vector<double>& gains, double errors) const {
        if (gains.size() < 2) {
            return 1.0;
        }
        const auto n = static_cast<double>(gains.size());
        const double mean = std::accumulate(gains.begin(), gains.end(), 0.0) / n;
        double squares = 0.0;
        for (const double gain : gains) {
            squares += std::pow(gain - mean, 2);
        }
        const double expected = screened_.sense == 0 ? 1.0 : 0.5;
        return std::max(1.0, (mean + errors * std::sqrt(squares / (n * (n - 1.0)))) / expected);
    }

    // Of the gain in the data, family-wise; there has to be a family. Noise that was stated too small makes gains as
    // much too large as it makes the residuals.
    double p_of_gain(double bartlett) const {
        const double excess = std::pow(settings_.noise_factor, 2);
        return d_.screening.family->p_value(std::sqrt(std::max(0.0, leading_.gain / (bartlett * excess))));
    }

private:
    // Where the fits with the effect start: a little of it. False: interrupted.
    bool start() {
        const Candidate& candidate = task_.candidates[leading_.candidate];
        const double found = leading_.fit->model.unit.back();
        constexpr double step = 0.1;
        with_ = d_.baseline.model.unit;
        with_.push_back(candidate.null + step * (found - candidate.null));
        task_.bench.chain(
            members_, settings_.number + settings_.simulations,
            [&](const problem::Problem& problem, run::Chain& chain) {
                at_with_ = shifted(problem, chain.at(with_), screened_.shift);
            },
            Mesh::coarse);
        return !run::interrupted();
    }

    // That a reading is the limit that it is, by what that adds to chi2: -2 ln of it.
    double probability_of(double residual) const { return std::exp(-0.5 * residual * residual / d_.variance); }

    std::optional<double> gain_by_chance(std::size_t b) const {
        if (!at_with_.converged()) {
            return std::nullopt;
        }
        const pave::RandomStream random(task_.seed, 100 + b);
        const pave::RandomStream kept(task_.seed, 1000000 + b);
        const double noise = std::sqrt(d_.variance);
        Target target;
        target.offset = -d_.baseline.model.residuals;
        for (Eigen::Index i = 0; i < target.offset.size(); ++i) {
            const auto number = static_cast<std::uint64_t>(i);
            if (task_.is_limit(static_cast<std::size_t>(i)) &&
                kept.uniform(number) < probability_of(target.offset[i])) {
                target.offset[i] = 0.0; // the limit that it is
            } else {                    // what the instrument reads is no limit, and drawn like any other
                target.offset[i] += noise * random.normal(number);
            }
        }
        const OnCoarse& base = d_.screening.base;
        const int number = settings_.number + static_cast<int>(b);
        FitSettings settings = for_residuals(&base.evaluation, d_.variance);
        settings.on_coarse = &base.shift;
        settings.enough = 0.05 * d_.variance; // half of the change of chi2, whose mean gain is 1
        const auto without = fit_from(task_.bench, {}, number, d_.baseline.model.unit, d_.variance, target, settings);
        settings.at_start = &at_with_;
        settings.on_coarse = &screened_.shift;
        const auto extended = fit_from(task_.bench, members_, number, with_, d_.variance, target, settings);
        return without && extended ? std::optional(std::max(0.0, without->sum - extended->sum) / d_.variance)
                                   : std::nullopt;
    }

    // Whether more simulated data could turn what these few say of the evidence.
    bool leave_doubt(const std::vector<double>& gains) const {
        constexpr double errors = 4.0; // standard errors of the mean that more data may move it by
        const bool was_reached =
            std::any_of(gains.begin(), gains.end(), [&](double by_chance) { return by_chance >= leading_.gain; });
        constexpr std::size_t least = 5;
        return was_reached || gains.size() < least || !d_.screening.family ||
               p_of_gain(bartlett(gains, errors)) > 0.1 * level_evidence;
    }

    const DiagnosisTask& task_;
    const Diagnosis& d_;
    const SimulationSettings& settings_;
    const EffectResult& leading_;
    const Screened& screened_;
    const Members& members_;
    std::vector<double> with_;
    problem::Evaluation at_with_;
};

} // namespace

bool weigh_evidence(const DiagnosisTask& task, Diagnosis& d, const SimulationSettings& settings) {
    Simulation simulation(task, d, settings);
    const auto gains = simulation.gains();
    if (!gains) {
        return false;
    }
    d.bootstrap = static_cast<int>(gains->size());
    d.bootstrap_above = static_cast<int>(
        std::count_if(gains->begin(), gains->end(), [&](double gain) { return gain >= d.effects[0].gain; }));
    d.bartlett = simulation.bartlett(*gains, 0.0);
    if (d.screening.family) {
        d.p_evidence = simulation.p_of_gain(d.bartlett);
    }
    return true;
}

} // namespace explore::diagnose
