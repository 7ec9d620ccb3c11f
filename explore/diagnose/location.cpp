#include "diagnose/location.h"

#include "diagnose/evidence.h"
#include "diagnose/steps/investigation.h"
#include "inference/quantiles.h"
#include "run/parallel.h"
#include "run/progress.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>

namespace explore::diagnose {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double level_correction = 0.05; // of being due to chance
constexpr std::size_t most_corrections = 3;

class Locator {
public:
    // base: what is to be corrected; its effects are followed as the parameters are.
    Locator(const DiagnosisTask& task, const Diagnosis& d, const Model& base)
        : task_(task),
          d_(d),
          noise_(std::sqrt(d.variance)),
          estimated_(!task.bench.problem({})->noise_is_stated()),
          parameters_(base.unit.size() - base.members.size()),
          followed_(base.unit.size()),
          model_(base),
          problem_(task.bench.problem(base.members)),
          arena_(run::concurrency(task.bench.threads())) {}

    // Fits corrections, as many as the data call for; nothing in the location: none, or none that is worth it. worth:
    // what AICc with them has to come below. False: interrupted.
    bool run(double worth, std::optional<Location>& location) {
        while (!is_done_ && accepted_.size() < most_corrections) {
            if (!differentiate()) {
                return false;
            }
            const auto tests = test();
            const std::size_t best = best_of(tests);
            // The AICc that this one promises, and each that may follow, or twice that: fits find up to so much
            // more than the linear evidence.
            const auto further = static_cast<double>(std::max<std::size_t>(2, most_corrections - accepted_.size()));
            const double promised = 2.0 * tests[best].log_ratio * further;
            const double reached = accepted_.empty() ? d_.baseline.aicc : aicc_now();
            if (tests[best].p_familywise >= level_correction || reached - promised > worth) {
                break;
            }
            add(best, tests);
            if (!fit_strengths()) {
                return false;
            }
        }
        if (!accepted_.empty()) {
            location = report();
        }
        return true;
    }

    // The chance that noise makes as much of a correction of the base as there is, of every channel. False:
    // interrupted.
    bool test_base(std::vector<double>& p) {
        if (!differentiate()) {
            return false;
        }
        for (const ChannelTest& own : test()) {
            p.push_back(own.p_familywise);
        }
        return true;
    }

private:
    std::vector<ChannelTest> test() const {
        return test_channels(uncorrected(), changes_, accepted_, nuisance(), estimated_, task_.seed + accepted_.size());
    }
    static std::size_t best_of(const std::vector<ChannelTest>& tests) {
        const auto best = std::max_element(tests.begin(), tests.end(),
                                           [](const auto& a, const auto& b) { return a.log_ratio < b.log_ratio; });
        return static_cast<std::size_t>(best - tests.begin());
    }

    inference::Nuisance nuisance() const {
        const MatrixXd jacobian = problem_->residual_jacobian(model_.evaluation) / noise_;
        const auto followed = static_cast<std::ptrdiff_t>(followed_);
        return {jacobian.leftCols(followed),
                {model_.unit.begin(), model_.unit.begin() + followed},
                model_.residuals / noise_};
    }

    Members members_with(const std::vector<std::size_t>& more) const {
        Members members = model_.members;
        for (const std::size_t c : more) {
            for (std::size_t i = 0; i < task_.channels[c].count; ++i) {
                members = with_member(std::move(members), task_.channels[c].first + i);
            }
        }
        return members;
    }

    // The model's point among these members, whose further ones correct nothing.
    std::vector<double> point_in(const Members& members) const {
        std::vector<double> unit(model_.unit.begin(), model_.unit.begin() + static_cast<std::ptrdiff_t>(parameters_));
        for (const std::size_t m : members) {
            const auto own = std::lower_bound(model_.members.begin(), model_.members.end(), m);
            const bool is_own = own != model_.members.end() && *own == m;
            unit.push_back(is_own ? model_.unit[parameters_ + static_cast<std::size_t>(own - model_.members.begin())]
                                  : no_correction);
        }
        return unit;
    }

    // Where the coefficients of a channel stand among the unit coordinates of a model.
    Index place_of(const Members& members, std::size_t channel) const {
        const auto at = std::lower_bound(members.begin(), members.end(), task_.channels[channel].first);
        return static_cast<Index>(parameters_) + (at - members.begin());
    }

    // d(coefficient)/d(unit coordinate).
    static double slope_of(const problem::Problem& problem, Index place) {
        const problem::Axis& axis = problem.space.axes[static_cast<std::size_t>(place)];
        return std::log(axis.high / axis.low);
    }

    // Fills changes_: residuals in standard deviations by the coefficients of every channel, at the model. On the
    // study's own mesh: what is accepted rests on them. False: interrupted.
    bool differentiate() {
        changes_.assign(task_.channels.size(), MatrixXd::Zero(model_.residuals.size(), 0));
        std::vector<std::vector<std::size_t>> batches; // of few coefficients each: runs side by side
        const std::size_t room = task_.bench.most_numbers() - model_.unit.size();
        const std::size_t most = std::min<std::size_t>(24, room);
        std::size_t taken = most;
        for (std::size_t c = 0; c < task_.channels.size(); ++c) {
            const std::size_t count = task_.channels[c].count;
            if (is_accepted(c)) {
                changes_[c] = changes_by(*problem_, model_.members, model_.evaluation, c);
                continue;
            }
            if (count > room) { // no model has as many numbers
                continue;
            }
            if (taken + count > most) {
                batches.emplace_back();
                taken = 0;
            }
            batches.back().push_back(c);
            taken += count;
        }
        run::Progress progress("corrections", static_cast<std::int64_t>(batches.size()));
        const int number = slope_number + static_cast<int>(accepted_.size());
        run::for_each_index(arena_, batches.size(), [&](std::size_t b) {
            const Members members = members_with(batches[b]);
            task_.bench.chain(members, number, [&](const problem::Problem& problem, run::Chain& chain) {
                const auto evaluation = chain.at(point_in(members));
                for (const std::size_t c : batches[b]) {
                    if (evaluation.converged()) {
                        changes_[c] = changes_by(problem, members, evaluation, c);
                    }
                }
            });
            progress.add(1, true);
        });
        return !run::interrupted();
    }

    MatrixXd changes_by(const problem::Problem& problem, const Members& members, const problem::Evaluation& evaluation,
                        std::size_t channel) const {
        const Index place = place_of(members, channel);
        return problem.residual_jacobian(evaluation)
                   .middleCols(place, static_cast<Index>(task_.channels[channel].count)) /
               (noise_ * slope_of(problem, place));
    }

    VectorXd coefficients_of(std::size_t channel) const {
        const Index place = place_of(model_.members, channel);
        VectorXd c(static_cast<Index>(task_.channels[channel].count));
        for (Index i = 0; i < c.size(); ++i) {
            c[i] = std::log(problem_->space.axes[static_cast<std::size_t>(place + i)].physical(
                model_.unit[static_cast<std::size_t>(place + i)]));
        }
        return c;
    }

    // The residuals in standard deviations as they would be without the corrections, to first order.
    VectorXd uncorrected() const {
        VectorXd z = model_.residuals / noise_;
        for (const Accepted& a : accepted_) {
            z -= changes_[a.channel] * coefficients_of(a.channel);
        }
        return z;
    }

    bool is_accepted(std::size_t channel) const {
        return std::any_of(accepted_.begin(), accepted_.end(), [&](const Accepted& a) { return a.channel == channel; });
    }

    void add(std::size_t channel, const std::vector<ChannelTest>& tests) {
        constexpr double nearly = 3.0; // of the logarithm of the ratio: 1 to 20
        Correction found{.channel = channel,
                         .log_ratio = tests[channel].log_ratio,
                         .p_familywise = tests[channel].p_familywise,
                         .alike = {},
                         .explained_by = {}};
        for (std::size_t c = 0; c < tests.size(); ++c) {
            if (c != channel && tests[c].log_ratio > tests[channel].log_ratio - nearly && !is_accepted(c) &&
                tests[c].p_familywise < level_correction) {
                found.alike.push_back(c);
            }
        }
        std::stable_sort(found.alike.begin(), found.alike.end(),
                         [&](std::size_t a, std::size_t b) { return tests[a].log_ratio > tests[b].log_ratio; });
        location_.corrections.push_back(std::move(found));
        accepted_.push_back({channel, tests[channel].strength});
        estimate_strengths(uncorrected_with_none(channel), changes_, accepted_, nuisance(), estimated_);
    }

    // As uncorrected(), a channel that has no coefficients in the model yet being accepted last.
    VectorXd uncorrected_with_none(std::size_t channel) const {
        VectorXd z = model_.residuals / noise_;
        for (const Accepted& a : accepted_) {
            if (a.channel != channel) {
                z -= changes_[a.channel] * coefficients_of(a.channel);
            }
        }
        return z;
    }

    // The terms that pull the coefficients of these members to nothing, in the unit of the residuals.
    Target penalised(const problem::Problem& problem, const Members& members) const {
        const auto n = static_cast<Index>(parameters_ + members.size());
        Target target;
        target.penalty = MatrixXd::Zero(n - static_cast<Index>(followed_), n);
        target.centre = VectorXd::Constant(n, no_correction);
        Index row = 0;
        for (const Accepted& a : accepted_) {
            const std::size_t count = task_.channels[a.channel].count;
            const auto k = static_cast<Index>(count);
            const Index place = place_of(members, a.channel);
            const MatrixXd factor = prior_correlation(count).llt().matrixL();
            target.penalty.block(row, place, k, k) = factor.triangularView<Eigen::Lower>().solve(
                MatrixXd::Identity(k, k) * (noise_ * slope_of(problem, place) / a.strength));
            row += k;
        }
        return target;
    }

    // The full model with the accepted corrections; the strengths again from where it ends, and once more. False:
    // interrupted.
    bool fit_strengths() {
        const std::size_t latest = accepted_.back().channel;
        const Members members = members_with({latest});
        std::vector<double> start = point_in(members);
        constexpr int passes = 2;
        const auto corrected = task_.bench.problem(members);
        for (int pass = 0; pass < passes; ++pass) {
            const Target target = penalised(*corrected, members);
            const int number = corrected_fit_number + 10 * static_cast<int>(accepted_.size()) + pass;
            std::optional<Model> found = fit_from(task_.bench, members, number, start, d_.variance, target,
                                                  {.at_start = pass > 0 ? &model_.evaluation : nullptr});
            if (run::interrupted()) {
                return false;
            }
            if (!found && pass == 0) { // no answer with it
                accepted_.pop_back();
                location_.corrections.pop_back();
                is_done_ = true;
            }
            if (!found) {
                break;
            }
            model_ = std::move(*found);
            problem_ = corrected;
            start = model_.unit;
            for (const Accepted& a : accepted_) {
                changes_[a.channel] = changes_by(*problem_, members, model_.evaluation, a.channel);
            }
            const std::vector<Accepted> before = accepted_;
            estimate_strengths(uncorrected(), changes_, accepted_, nuisance(), estimated_);
            constexpr double same = 0.1;
            const bool is_settled =
                std::equal(before.begin(), before.end(), accepted_.begin(), [](const Accepted& a, const Accepted& b) {
                    return std::abs(std::log(a.strength / b.strength)) < same;
                });
            if (is_settled || pass + 1 == passes) {
                accepted_ = before; // those of the fit
                break;
            }
        }
        return true;
    }

    Location report() {
        location_.pull = penalised(*problem_, model_.members);
        location_.covariance = covariance();
        location_.fit = judge();
        location_.numbers = static_cast<int>(numbers());
        const inference::Nuisance beyond = nuisance();
        for (std::size_t i = 0; i < accepted_.size(); ++i) {
            Correction& correction = location_.corrections[i];
            correction.strength = accepted_[i].strength;
            compare(beyond.beyond(changes_[correction.channel] * coefficients_of(correction.channel)), beyond,
                    correction);
        }
        return std::move(location_);
    }

    // Of the unit coordinates of the model.
    MatrixXd covariance() const {
        const MatrixXd jacobian = problem_->residual_jacobian(model_.evaluation) / noise_;
        const MatrixXd pulls = penalised(*problem_, model_.members).penalty / noise_;
        MatrixXd precision = jacobian.transpose() * jacobian + pulls.transpose() * pulls;
        constexpr double weak = 0.01; // as of every interval
        precision.diagonal().head(static_cast<Index>(followed_)).array() += weak / inference::box_variance;
        return precision.llt().solve(MatrixXd::Identity(precision.rows(), precision.cols()));
    }

    // Coefficients, as far as the data set them free.
    std::size_t numbers() const {
        const MatrixXd pulls = penalised(*problem_, model_.members).penalty / noise_;
        const double held = (covariance() * (pulls.transpose() * pulls)).trace();
        const auto free = static_cast<double>(model_.unit.size() - followed_) - held;
        return static_cast<std::size_t>(std::lround(std::max(0.0, free)));
    }
    // Residuals that are draws of the noise.
    std::size_t drawn() const { return static_cast<std::size_t>(model_.residuals.size()) - problem_->censored(); }
    double aicc_now() const {
        return aicc(model_.residuals.squaredNorm(), drawn(), followed_ + numbers(), !estimated_);
    }

    // Coefficients as they are held by what is known of them beforehand; their strength was chosen by the data.
    hypotheses::Evidence evidence(const MatrixXd& jacobian) const {
        const auto followed = static_cast<Index>(followed_);
        const MatrixXd pulls = penalised(*problem_, model_.members).penalty / noise_;
        const Index count = static_cast<Index>(model_.unit.size()) - followed;
        VectorXd away(count);
        for (Index i = 0; i < count; ++i) {
            away[i] = model_.unit[static_cast<std::size_t>(followed + i)] - no_correction;
        }
        auto prior = hypotheses::Prior::of_parameters(followed);
        prior.add_normal((pulls.transpose() * pulls).bottomRightCorner(count, count), away);
        constexpr double chosen = 1.0; // what the best strength says more than strengths do on average, about
        prior.log_volume -= chosen * static_cast<double>(accepted_.size());
        return hypotheses::evidence(model_.residuals.squaredNorm() / d_.variance, static_cast<Index>(drawn()), jacobian,
                                    prior, estimated_ ? hypotheses::any_noise() : hypotheses::NoisePrior{});
    }

    Judged judge() const {
        Judged fit;
        fit.chi2 = model_.sum / d_.variance;
        fit.dof = static_cast<int>(drawn()) - nuisance().rank();
        if (!estimated_ && fit.dof > 0) {
            fit.p_value = gsl_cdf_chisq_Q(fit.chi2, fit.dof);
        }
        fit.aicc = aicc_now();
        const MatrixXd jacobian = problem_->residual_jacobian(model_.evaluation) / noise_;
        fit.pattern = test_pattern(model_.residuals / noise_,
                                   inference::Nuisance(jacobian, model_.unit, model_.residuals / noise_), task_.groups);
        fit.evidence = evidence(jacobian);
        fit.model = model_;
        return fit;
    }

    // The part of this change of the residuals that each effect makes.
    void compare(const VectorXd& change, const inference::Nuisance& nuisance, Correction& correction) const {
        constexpr double alike = 0.5;
        for (std::size_t e = 0; e < d_.effects.size(); ++e) {
            const EffectResult& effect = d_.effects[e];
            VectorXd own = d_.screening.items[effect.candidate].change;
            if (effect.fit) {
                own = nuisance.beyond(effect.fit->model.residuals - d_.baseline.model.residuals);
            }
            const double length = own.size() > 0 ? own.norm() : 0.0;
            const double whole = change.norm();
            if (!(length > 0.0 && whole > 0.0)) {
                continue;
            }
            const double cosine = own.dot(change) / (length * whole);
            const int sense = effect.fit ? 1 : d_.screening.items[effect.candidate].sense;
            if (cosine * cosine < alike || cosine * sense < 0.0) {
                continue;
            }
            correction.explained_by.push_back(
                {.effect = e, .share = cosine * cosine, .leaves_noise = effect.fit && leaves_noise(*effect.fit)});
        }
        std::stable_sort(correction.explained_by.begin(), correction.explained_by.end(),
                         [](const Likeness& a, const Likeness& b) { return a.share > b.share; });
    }

    bool leaves_noise(const Judged& j) const {
        return estimated_ || std::min(j.p_value, j.pattern.p_value) >= level_noise;
    }

    const DiagnosisTask& task_;
    const Diagnosis& d_;
    double noise_; // unit of the residuals
    bool estimated_;
    std::size_t parameters_;                          // of the study
    std::size_t followed_;                            // they and the sizes of the base's effects
    Model model_;                                     // with what is accepted
    std::shared_ptr<const problem::Problem> problem_; // of the model
    tbb::task_arena arena_;
    std::vector<Accepted> accepted_;
    std::vector<MatrixXd> changes_; // of every channel, at the model
    Location location_;
    bool is_done_ = false;
};

} // namespace

bool find_corrections(const DiagnosisTask& task, const Diagnosis& d, double worth, std::optional<Location>& location) {
    return Locator(task, d, d.baseline.model).run(worth, location);
}

bool test_beside(const DiagnosisTask& task, const Diagnosis& d, const Model& base, std::vector<double>& p) {
    return Locator(task, d, base).test_base(p);
}

} // namespace explore::diagnose
