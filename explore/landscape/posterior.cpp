#include "landscape/posterior.h"

#include "base/random.h"
#include "run/progress.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_randist.h>
#include <numeric>

namespace explore::landscape {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double decorrelated = 0.5;      // between powers: correlation of a coordinate with where the moves began
constexpr double decorrelated_last = 0.2; // at the end
constexpr double share_of_others = 0.3;   // of proposals that come from another particle
constexpr double keep_own[] = {0.0, 0.6, 0.9};
constexpr double keep_other = 0.6;
constexpr int most_first_draws = 20; // draws from the prior for each particle that has to have an answer

// A point with what the proposals need.
struct Particle {
    VectorXd x;
    std::vector<double> unit;
    std::vector<double> responses;
    double log_likelihood = -std::numeric_limits<double>::infinity();
    VectorXd slope;  // J' r, by x
    MatrixXd normal; // J' J
    int ancestor = 0;
};

std::vector<double> unit_of(const VectorXd& x) {
    std::vector<double> unit;
    for (const double value : x) {
        unit.push_back(gsl_cdf_ugaussian_P(value));
    }
    return unit;
}

Particle particle_of(const problem::Problem& problem, VectorXd x, std::vector<double> unit,
                     problem::Evaluation evaluation) {
    Particle p;
    p.x = std::move(x);
    p.unit = std::move(unit);
    if (!evaluation.converged()) {
        return p;
    }
    MatrixXd j = problem.residual_jacobian(evaluation);
    for (Eigen::Index k = 0; k < j.cols(); ++k) {
        j.col(k) *= gsl_ran_ugaussian_pdf(p.x[k]);
    }
    VectorXd rows = problem.residuals(evaluation);
    const auto readings = static_cast<Eigen::Index>(problem.readings());
    const double scale = problem.noise_scale(evaluation);
    rows.head(readings) /= scale;
    j.topRows(readings) /= scale;
    p.slope = j.transpose() * rows;
    p.normal = j.transpose() * j;
    const double log_likelihood = problem.log_density(evaluation);
    if (std::isfinite(log_likelihood) && p.normal.allFinite() && p.slope.allFinite()) {
        p.log_likelihood = log_likelihood;
    }
    p.responses = std::move(evaluation.responses);
    return p;
}

// The Gaussian around the Gauss-Newton step of a particle.
struct Local {
    VectorXd x, centre;
    MatrixXd root;         // upper triangle U of the precision U'U
    double log_root = 0.0; // logarithm of its determinant

    Local(const Particle& p, double power) : x(p.x) {
        const Eigen::LLT<MatrixXd> precision(MatrixXd(power * p.normal + MatrixXd::Identity(x.size(), x.size())));
        centre = x - precision.solve(power * p.slope + x);
        root = precision.matrixU();
        log_root = root.diagonal().array().log().sum();
    }
    VectorXd draw(double keep, const VectorXd& normal) const {
        return centre + keep * (x - centre) +
               std::sqrt(1.0 - keep * keep) * root.triangularView<Eigen::Upper>().solve(normal);
    }
    // Less what all have in common.
    double log_density(double keep, const VectorXd& at) const {
        const double rest = 1.0 - keep * keep;
        const Eigen::Index n = x.size();
        double squares = 0.0;
        for (Eigen::Index i = 0; i < n; ++i) {
            double sum = 0.0;
            for (Eigen::Index k = i; k < n; ++k) {
                sum += root(i, k) * (at[k] - centre[k] - keep * (x[k] - centre[k]));
            }
            squares += sum * sum;
        }
        return log_root - 0.5 * static_cast<double>(n) * std::log(rest) - 0.5 * squares / rest;
    }
};

double log_mean_exp(const std::vector<double>& logarithms) {
    const double top = *std::max_element(logarithms.begin(), logarithms.end());
    double sum = 0.0;
    for (const double value : logarithms) {
        sum += std::exp(value - top);
    }
    return top + std::log(sum / static_cast<double>(logarithms.size()));
}

class Population {
public:
    Population(const problem::Problem& problem, std::uint64_t seed, int number)
        : problem_(problem),
          stream_(seed, 0x5a3b1e00ULL + static_cast<std::uint64_t>(number)) {}

    std::vector<Particle> particles;
    double power = 0.0;
    double log_evidence = 0.0;
    int powers = 0, sweeps = 0;
    std::int64_t proposed[2] = {0, 0}, accepted[2] = {0, 0}; // own, of others; at the present power

    double uniform() { return stream_.uniform(2 * next_++); } // normals use two numbers
    double normal() { return stream_.normal(next_++); }

    // Raises the power, weighs, and draws anew.
    void advance(double keep) {
        const std::size_t n = particles.size();
        std::vector<double> logarithm(n);
        const auto weigh = [&](double to) {
            for (std::size_t i = 0; i < n; ++i) {
                logarithm[i] = (to - power) * particles[i].log_likelihood;
            }
            const double top = *std::max_element(logarithm.begin(), logarithm.end());
            double sum = 0.0;
            double squares = 0.0;
            for (const double value : logarithm) {
                const double w = std::exp(value - top);
                sum += w;
                squares += w * w;
            }
            return sum * sum / squares;
        };
        double to = 1.0;
        if (weigh(to) < keep * static_cast<double>(n)) {
            double low = power;
            for (int i = 0; i < 60; ++i) {
                const double middle = 0.5 * (low + to);
                (weigh(middle) < keep * static_cast<double>(n) ? to : low) = middle;
            }
            weigh(to);
        }
        log_evidence += log_mean_exp(logarithm);
        const double top = *std::max_element(logarithm.begin(), logarithm.end());
        double total = 0.0;
        for (double& value : logarithm) {
            value = std::exp(value - top);
            total += value;
        }
        std::vector<Particle> drawn;
        drawn.reserve(n);
        const double offset = uniform();
        double sum = 0.0;
        for (std::size_t i = 0; i < n && drawn.size() < n; ++i) {
            sum += logarithm[i] * static_cast<double>(n) / total;
            while (drawn.size() < n &&
                   (static_cast<double>(drawn.size()) + offset < sum || (i + 1 == n && drawn.size() < n))) {
                drawn.push_back(particles[i]);
            }
        }
        particles = std::move(drawn);
        power = to;
        ++powers;
        start_here();
        std::fill(std::begin(proposed), std::end(proposed), 0);
        std::fill(std::begin(accepted), std::end(accepted), 0);
    }

    // From where the particles are now their moves are counted, and their correlation is measured.
    void start_here() {
        began_.clear();
        for (const Particle& p : particles) {
            began_.push_back(p.x);
        }
        here_ = 0;
    }

    int sweeps_here() const { return here_; }
    // Largest correlation of a coordinate with its value where the moves began.
    double correlation() const {
        double largest = 0.0;
        const std::vector<double> weight(particles.size(), 1.0);
        for (Eigen::Index k = 0; k < particles[0].x.size(); ++k) {
            std::vector<double> then, now;
            for (std::size_t i = 0; i < particles.size(); ++i) {
                then.push_back(began_[i][k]);
                now.push_back(particles[i].x[k]);
            }
            largest = std::max(largest, weighted_correlation(then, now, weight));
        }
        return largest;
    }

    // Proposals for the even (0) or odd (1) particles.
    std::vector<std::vector<double>> propose(std::size_t half) {
        locals_.clear();
        for (const Particle& p : particles) {
            locals_.emplace_back(p, power);
        }
        moves_.clear();
        std::vector<std::vector<double>> points;
        for (std::size_t i = half; i < particles.size(); i += 2) {
            Move move{.particle = i};
            move.own = uniform() >= share_of_others;
            const double choice = uniform();
            std::size_t from = i;
            if (move.own) {
                move.keep = keep_own[std::min<std::size_t>(std::size(keep_own) - 1,
                                                           static_cast<std::size_t>(choice * std::size(keep_own)))];
            } else {
                move.keep = keep_other;
                const std::size_t others = particles.size() / 2;
                from =
                    1 - half + 2 * std::min(others - 1, static_cast<std::size_t>(choice * static_cast<double>(others)));
            }
            VectorXd z(particles[i].x.size());
            for (double& value : z) {
                value = normal();
            }
            move.x = locals_[from].draw(move.keep, z);
            move.uniform = uniform();
            points.push_back(unit_of(move.x));
            moves_.push_back(std::move(move));
        }
        half_ = half;
        return points;
    }

    // evaluations: of the proposals, from this place on.
    void decide(std::vector<std::vector<double>> points, std::vector<problem::Evaluation>::iterator evaluation) {
        for (std::size_t m = 0; m < moves_.size(); ++m, ++evaluation) {
            const Move& move = moves_[m];
            Particle& old = particles[move.particle];
            const int kind = move.own ? 0 : 1;
            ++proposed[kind];
            Particle to = particle_of(problem_, move.x, std::move(points[m]), std::move(*evaluation));
            if (to.log_likelihood == -std::numeric_limits<double>::infinity()) {
                continue;
            }
            double ratio =
                power * (to.log_likelihood - old.log_likelihood) - 0.5 * (to.x.squaredNorm() - old.x.squaredNorm());
            if (move.own) {
                ratio += Local(to, power).log_density(move.keep, old.x) -
                         locals_[move.particle].log_density(move.keep, to.x);
            } else {
                ratio += log_density_of_others(move.keep, old.x) - log_density_of_others(move.keep, to.x);
            }
            if (std::log(move.uniform) < ratio) {
                to.ancestor = old.ancestor;
                old = std::move(to);
                ++accepted[kind];
            }
        }
        if (half_ == 1) {
            ++sweeps;
            ++here_;
        }
    }

private:
    struct Move {
        std::size_t particle = 0;
        bool own = true;
        double keep = 0.0, uniform = 0.0;
        VectorXd x{};
    };

    // Of the half that does not move.
    double log_density_of_others(double keep, const VectorXd& at) const {
        std::vector<double> logarithms;
        for (std::size_t j = 1 - half_; j < locals_.size(); j += 2) {
            logarithms.push_back(locals_[j].log_density(keep, at));
        }
        return log_mean_exp(logarithms);
    }

    const problem::Problem& problem_;
    pave::RandomStream stream_;
    std::uint64_t next_ = 0;
    int here_ = 0;
    std::vector<VectorXd> began_;
    std::vector<Local> locals_;
    std::vector<Move> moves_;
    std::size_t half_ = 0;
};

// Points one after the other, of one design.
class Evaluator {
public:
    Evaluator(run::Engine& engine, bool show_progress) : engine_(engine), progress_("sample", show_progress ? 0 : -1) {}

    // Nothing: interrupted.
    std::optional<std::vector<problem::Evaluation>> operator()(const std::vector<std::vector<double>>& points) {
        const std::size_t first = design_.points.size();
        design_.points.insert(design_.points.end(), points.begin(), points.end());
        const std::int64_t before = engine_.tally().computed;
        auto evaluations = engine_.evaluate(design_, true, first);
        const std::int64_t computed = engine_.tally().computed - before;
        progress_.add(computed, true);
        progress_.add(static_cast<std::int64_t>(points.size()) - computed, false);
        return evaluations;
    }
    void note(std::string words) { progress_.note(std::move(words)); }

private:
    run::Engine& engine_;
    run::Progress progress_;
    search::Design design_{"sample", {}};
};

VectorXd normal_of(const std::vector<double>& unit) {
    VectorXd x(static_cast<Eigen::Index>(unit.size()));
    for (std::size_t k = 0; k < unit.size(); ++k) {
        x[static_cast<Eigen::Index>(k)] = gsl_cdf_ugaussian_Pinv(std::clamp(unit[k], 1e-12, 1.0 - 1e-12));
    }
    return x;
}

// Draws from the prior, as many with an answer as a population has particles; `reason`: why there are none.
std::optional<bool> begin(std::vector<Population>& populations, const problem::Problem& problem,
                          const PosteriorSettings& settings, std::uint64_t seed, Evaluator& evaluate,
                          Posterior& result) {
    const int n = settings.particles;
    std::size_t drawn = 0;
    std::size_t answered = 0;
    double of_prior = 0.0; // sums of densities of the prior, without the limits' factors and with them
    double allowed = 0.0;
    double squares = 0.0; // of the second
    for (std::size_t p = 0; p < populations.size(); ++p) {
        auto& particles = populations[p].particles;
        std::size_t own_drawn = 0;
        std::size_t own_answered = 0;
        std::string first_reason;
        for (int round = 0; round < most_first_draws && static_cast<int>(particles.size()) < n; ++round) {
            const auto all = search::sobol(problem.space, n * (round + 1), seed * 64 + p).points;
            const std::vector<std::vector<double>> points(all.begin() + static_cast<std::ptrdiff_t>(n) * round,
                                                          all.end());
            auto evaluations = evaluate(points);
            if (!evaluations) {
                return std::nullopt;
            }
            own_drawn += points.size();
            for (std::size_t i = 0; i < points.size(); ++i) {
                if (first_reason.empty()) {
                    first_reason = (*evaluations)[i].reason;
                }
                if ((*evaluations)[i].converged() && !problem.limits.empty()) {
                    const auto rows = problem.residuals((*evaluations)[i]);
                    const auto count = static_cast<Eigen::Index>(problem.limits.size());
                    const double prior =
                        std::exp(-0.5 * rows.segment(static_cast<Eigen::Index>(problem.readings()),
                                                     static_cast<Eigen::Index>(problem.priors().size()))
                                            .squaredNorm());
                    const double with = prior * std::exp(-0.5 * rows.tail(count).squaredNorm());
                    of_prior += prior;
                    allowed += with;
                    squares += with * with;
                }
                Particle particle = particle_of(problem, normal_of(points[i]), points[i], std::move((*evaluations)[i]));
                if (std::isfinite(particle.log_likelihood)) {
                    ++own_answered;
                    if (static_cast<int>(particles.size()) < n) {
                        particle.ancestor = static_cast<int>(particles.size());
                        particles.push_back(std::move(particle));
                    }
                }
            }
            if (own_answered == 0) { // so many without an answer: not one more is expected
                break;
            }
        }
        drawn += own_drawn;
        answered += own_answered;
        if (static_cast<int>(particles.size()) < n) {
            result.reason = own_answered == 0
                                ? "not one point drawn from the prior has an answer; the first says: " + first_reason
                                : fmt::format("{} of {} points drawn from the prior have an answer: too few to begin "
                                              "with; one says: {}",
                                              own_answered, own_drawn, first_reason);
            return false;
        }
        populations[p].log_evidence = std::log(static_cast<double>(own_answered) / static_cast<double>(own_drawn));
    }
    result.answered = static_cast<double>(answered) / static_cast<double>(drawn);
    constexpr double least = 20.0; // effective draws
    if (allowed > 0.0 && allowed * allowed >= least * squares) {
        const double share = allowed / of_prior;
        result.allowed = AllowedShare{.log = std::log(share),
                                      .error = std::sqrt(std::max(0.0, 1.0 - share) * squares / (allowed * allowed))};
    }
    return true;
}

// One sweep of moves over these populations; false: interrupted.
bool sweep(const std::vector<Population*>& populations, Evaluator& evaluate) {
    for (const std::size_t half : {std::size_t{0}, std::size_t{1}}) {
        std::vector<std::vector<std::vector<double>>> proposals;
        std::vector<std::vector<double>> all;
        for (Population* p : populations) {
            proposals.push_back(p->propose(half));
            all.insert(all.end(), proposals.back().begin(), proposals.back().end());
        }
        auto evaluations = evaluate(all);
        if (!evaluations) {
            return false;
        }
        auto at = evaluations->begin();
        for (std::size_t k = 0; k < populations.size(); ++k) {
            const auto count = static_cast<std::ptrdiff_t>(proposals[k].size());
            populations[k]->decide(std::move(proposals[k]), at);
            at += count;
        }
    }
    return true;
}

Descent descent_of(const std::vector<Population>& populations) {
    Descent descent;
    for (std::size_t p = 0; p < populations.size(); ++p) {
        for (const Particle& particle : populations[p].particles) {
            descent.weight.push_back(1.0);
            descent.population.push_back(static_cast<int>(p));
            descent.ancestor.push_back(particle.ancestor);
        }
    }
    return descent;
}

bool good_enough(const std::vector<Population>& populations) {
    const Descent descent = descent_of(populations);
    const auto dimension = populations[0].particles[0].x.size();
    const double enough = std::max(least_ess, std::min(2.0 * least_ess, 0.25 * static_cast<double>(descent.size())));
    for (Eigen::Index k = 0; k < dimension; ++k) {
        std::vector<double> values;
        for (const Population& p : populations) {
            for (const Particle& particle : p.particles) {
                values.push_back(particle.x[k]);
            }
        }
        const Marginal m = marginal(values, descent);
        if (m.rhat > most_rhat || m.ess < enough) {
            return false;
        }
    }
    return true;
}

// The particles where they are, as draws.
void take(const std::vector<Population>& populations, Posterior& result) {
    for (const Population& p : populations) {
        for (const Particle& particle : p.particles) {
            result.draws.push_back({particle.unit, particle.responses, particle.log_likelihood});
        }
    }
    const Descent descent = descent_of(populations);
    const auto append = [](auto& all, const auto& more) { all.insert(all.end(), more.begin(), more.end()); };
    append(result.descent.weight, descent.weight);
    append(result.descent.population, descent.population);
    append(result.descent.ancestor, descent.ancestor);
}

void summarise(const std::vector<Population>& populations, Posterior& result) {
    std::int64_t proposed[2] = {0, 0};
    std::int64_t accepted[2] = {0, 0};
    for (const Population& p : populations) {
        result.log_evidences.push_back(p.log_evidence);
        result.powers = std::max(result.powers, p.powers);
        result.sweeps = std::max(result.sweeps, p.sweeps);
        for (int kind = 0; kind < 2; ++kind) {
            proposed[kind] += p.proposed[kind];
            accepted[kind] += p.accepted[kind];
        }
    }
    const auto share = [&](int kind) {
        return static_cast<double>(accepted[kind]) / static_cast<double>(std::max<std::int64_t>(1, proposed[kind]));
    };
    result.accepted_own = share(0);
    result.accepted_other = share(1);
    result.log_evidence = log_mean_exp(result.log_evidences);
    double variance = 0.0; // of a population's evidence, relative to the mean
    const auto m = static_cast<double>(populations.size());
    for (const double value : result.log_evidences) {
        variance += std::pow(std::expm1(value - result.log_evidence), 2) / (m - 1.0);
    }
    result.log_evidence_error = std::sqrt(variance / m);
}

} // namespace

std::optional<Posterior> posterior(run::Engine& engine, const problem::Problem& problem,
                                   const PosteriorSettings& settings, std::uint64_t seed) {
    Posterior result;
    Evaluator evaluate(engine, settings.show_progress);
    std::vector<Population> populations;
    populations.reserve(static_cast<std::size_t>(settings.populations));
    for (int p = 0; p < settings.populations; ++p) {
        populations.emplace_back(problem, seed, p);
    }
    const auto begun = begin(populations, problem, settings, seed, evaluate, result);
    if (!begun) {
        return std::nullopt;
    }
    if (!*begun) {
        return result;
    }
    for (Population& p : populations) {
        p.advance(settings.keep);
    }
    int rounds = 0;
    for (;;) {
        std::vector<Population*> moving;
        for (Population& p : populations) {
            const bool last = p.power >= 1.0;
            const bool done = p.sweeps_here() >= (last ? settings.most_last : settings.most_sweeps) ||
                              (p.sweeps_here() > 0 && p.correlation() < (last ? decorrelated_last : decorrelated));
            if (done && !last) {
                p.advance(settings.keep);
            }
            if (!done || !last) {
                moving.push_back(&p);
            }
        }
        if (moving.empty()) {
            const bool enough = result.descent.size() > 0 || good_enough(populations);
            if (enough || populations[0].sweeps_here() >= settings.most_last) {
                take(populations, result);
                if (++rounds == settings.rounds) {
                    break;
                }
                for (Population& p : populations) {
                    p.start_here();
                }
            }
            for (Population& p : populations) {
                moving.push_back(&p);
            }
        }
        const auto behind = std::min_element(populations.begin(), populations.end(),
                                             [](const auto& a, const auto& b) { return a.power < b.power; });
        evaluate.note(fmt::format("likelihood to the power {:.2g}", behind->power));
        if (!sweep(moving, evaluate)) {
            return std::nullopt;
        }
    }
    summarise(populations, result);
    return result;
}

} // namespace explore::landscape
