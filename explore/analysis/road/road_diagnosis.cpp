#include "analysis/road/road_diagnosis.h"

#include "analysis/road/road_decision.h"
#include "analysis/road/road_lacks.h"
#include "diagnose/screening.h"
#include "inference/nuisance.h"
#include "inference/quantiles.h"
#include "pavement/effects/effect.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gsl/gsl_cdf.h>
#include <map>
#include <numeric>

namespace explore::analysis {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double moves = 1.0;   // standard deviations that crossing the box must make for a parameter to follow
constexpr double behind = 10.0; // fall of chi2 below the most promising candidate's, of those that are fitted
constexpr std::size_t most_fits = 5;
constexpr int fit_number = 3000;

class Diagnoser {
public:
    Diagnoser(Session& session, const RoadState& state, double dof, const ProblemOfStation& problem_of)
        : session_(session),
          state_(state),
          problem_of_(problem_of) {
        for (const double squares : state.end.search.squares) {
            result_.chi2 += squares;
        }
        result_.dof = dof;
        result_.p_value = dof > 0.0 ? gsl_cdf_chisq_Q(result_.chi2, dof) : 1.0;
    }

    std::optional<RoadDiagnosis> run() {
        auto lacks = lacks_of_road(session_, state_, problem_of_);
        if (!lacks) {
            return std::nullopt;
        }
        lacks_ = std::move(*lacks);
        score();
        const bool is_chance = result_.effects.empty() || result_.effects[0].p_familywise >= road_familywise;
        if (!is_chance && !fit_promising()) {
            return std::nullopt;
        }
        decide_on_road(result_, confounding());
        return result_;
    }

private:
    std::size_t members() const { return state_.members.size(); }

    void score() {
        const auto n = static_cast<Index>(lacks_.size());
        const auto c = static_cast<Index>(state_.layout.common.size());
        // Of what stations leave: products of candidates, residuals (the last column) and common unknowns.
        MatrixXd products = MatrixXd::Zero(n + 1, n + 1);
        MatrixXd with_common = MatrixXd::Zero(c, n + 1);
        MatrixXd common = MatrixXd::Zero(c, c);
        for (std::size_t m = 0; m < members(); ++m) {
            const std::size_t i = state_.members[m];
            const RoadPoint& point = state_.points[i];
            const problem::Problem& problem = state_.tasks[i].problem;
            const MatrixXd jacobian = problem.residual_jacobian(point.evaluation);
            const Index rows = jacobian.rows();
            MatrixXd own(rows, 0);
            std::vector<double> free; // where its unknowns are
            MatrixXd columns = MatrixXd::Zero(rows, n + 1 + c);
            columns.col(n) = problem.residuals(point.evaluation);
            for (Index k = 0; k < n; ++k) {
                if (const VectorXd& change = lacks_[static_cast<std::size_t>(k)].change[m]; change.size() == rows) {
                    columns.col(k) = change;
                }
            }
            const auto& of = state_.layout.blocks[i].common;
            for (std::size_t k = 0; k < of.size(); ++k) {
                if (landscape::is_at_bound(point.unit[k])) {
                    continue; // the box holds it
                }
                if (of[k] == optimise::own_unknown) {
                    own.conservativeResize(Eigen::NoChange, own.cols() + 1);
                    own.col(own.cols() - 1) = jacobian.col(static_cast<Index>(k));
                    free.push_back(point.unit[k]);
                } else {
                    columns.col(n + 1 + of[k]) += jacobian.col(static_cast<Index>(k));
                }
            }
            const inference::Nuisance follows(own, free, columns.col(n));
            for (Index k = 0; k < columns.cols(); ++k) {
                columns.col(k) = follows.beyond(columns.col(k));
            }
            products += columns.leftCols(n + 1).transpose() * columns.leftCols(n + 1);
            with_common += columns.rightCols(c).transpose() * columns.leftCols(n + 1);
            common += columns.rightCols(c).transpose() * columns.rightCols(c);
        }
        const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(common);
        for (Index k = 0; k < c; ++k) {
            if (eigen.eigenvalues()[k] >= moves * moves) {
                const Eigen::RowVectorXd along = eigen.eigenvectors().col(k).transpose() * with_common;
                products -= along.transpose() * along / eigen.eigenvalues()[k];
            }
        }
        rank(products);
    }

    // products: of candidates and residuals, beyond what everything that is fitted follows.
    void rank(const MatrixXd& products) {
        const auto n = static_cast<Index>(lacks_.size());
        std::vector<Index> seen;
        for (Index k = 0; k < n; ++k) {
            if (products(k, k) >= moves * moves) {
                seen.push_back(k);
            }
        }
        const VectorXd lengths = products.diagonal().head(n).cwiseMax(1e-300).cwiseSqrt();
        const MatrixXd directions =
            lengths.cwiseInverse().asDiagonal() * products.topLeftCorner(n, n) * lengths.cwiseInverse().asDiagonal();
        if (seen.empty()) {
            return;
        }
        directions_ = directions;
        const inference::MaxStatistic chance = family(directions(seen, seen), seen);
        for (const Index k : seen) {
            const auto at = static_cast<std::size_t>(k);
            const Lack& lack = lacks_[at];
            RoadEffect effect;
            effect.candidate = at;
            effect.name = lack.variant ? std::string(lack.variant->applied.effect->name) : std::string(sensor_gain);
            const bool is_layout = lack.variant && !lack.variant->applied.offsets.empty();
            effect.kind = is_layout ? hypotheses::Kind::layout : hypotheses::Kind::effect;
            effect.on = is_layout        ? lack.variant->on
                        : lack.offset_mm ? fmt::format("the sensor at {:g} mm", *lack.offset_mm)
                                         : "";
            const double slope = -products(k, n) / products(k, k); // of the size that the residuals want
            effect.score = slope * lengths[k];
            const bool is_possible = lack.sense == 0 || lack.sense * slope > 0.0;
            const double strength = is_possible ? std::abs(effect.score) : 0.0;
            effect.p_familywise = std::min(1.0, chance.p_value(strength));
            promised_.emplace(at, strength * strength);
            if (!lack.variant) {
                gains_.emplace(at, std::pair(slope, 1.0 / lengths[k]));
            }
            result_.effects.push_back(std::move(effect));
        }
        std::stable_sort(result_.effects.begin(), result_.effects.end(), [&](const auto& a, const auto& b) {
            return promised_.at(a.candidate) > promised_.at(b.candidate);
        });
    }

    // How large the largest score gets by noise alone.
    inference::MaxStatistic family(const MatrixXd& correlation, const std::vector<Index>& seen) const {
        const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(correlation);
        const MatrixXd root =
            eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
        std::vector<int> sense;
        sense.reserve(seen.size());
        for (const Index k : seen) {
            sense.push_back(lacks_[static_cast<std::size_t>(k)].sense);
        }
        const inference::Nuisance nothing(MatrixXd::Zero(root.rows(), 1), {0.5}, VectorXd::Zero(root.rows()));
        return {root, sense, nothing, false, session_.options().seed};
    }

    // False: interrupted.
    bool fit_promising() {
        const double best = promised_.at(result_.effects[0].candidate);
        std::size_t fits = 0;
        for (RoadEffect& effect : result_.effects) {
            const double promised = promised_.at(effect.candidate);
            if (fits == most_fits || promised < best - behind || effect.p_familywise >= road_familywise) {
                break;
            }
            ++fits;
            if (!lacks_[effect.candidate].variant) {
                take_gain(effect, result_.chi2 - promised);
            } else if (!fit(effect)) {
                return false;
            }
        }
        return true;
    }

    // The readings of a sensor are multiplied by a factor: linear in its logarithm.
    void take_gain(RoadEffect& effect, double chi2) const {
        judge(effect, chi2);
        const auto& [share, deviation] = gains_.at(effect.candidate);
        set_gain(effect, *lacks_[effect.candidate].offset_mm, share, deviation, result_.dof);
    }

    // How often the readings tell each of the fitted effects from the one that promises most.
    std::vector<RoadConfounding> confounding() const {
        std::vector<RoadConfounding> list;
        for (const RoadEffect& effect : result_.effects) {
            const std::size_t first = result_.effects[0].candidate;
            if (effect.candidate == first || !effect.chi2) {
                continue;
            }
            double cosine = directions_(static_cast<Index>(first), static_cast<Index>(effect.candidate));
            const double towards = result_.effects[0].score * effect.score < 0.0 ? -1.0 : 1.0;
            cosine *= towards;
            const double strength = std::sqrt(promised_.at(first));
            list.push_back({.a = first,
                            .b = effect.candidate,
                            .rate = gsl_cdf_ugaussian_P(strength * std::sqrt(std::max(0.0, (1.0 - cosine) / 2.0)))});
        }
        return list;
    }

    void judge(RoadEffect& effect, double chi2) const {
        effect.chi2 = chi2;
        effect.p_value = gsl_cdf_chisq_Q(chi2, result_.dof - 1.0);
    }

    // Everything once more with this effect's size as one unknown of the road. False: interrupted.
    bool fit(RoadEffect& effect) {
        const study::Variant& first = *lacks_[effect.candidate].variant;
        const std::string key = key_of(first, state_.tasks[state_.members[0]].study);
        const auto size = static_cast<int>(state_.layout.common.size());
        const problem::Axis axis = study::size_axis(*first.applied.effect);
        std::vector<StationTask> tasks;
        std::vector<int> runs;
        std::vector<RoadPoint> points;
        RoadLayout layout{.common = state_.layout.common, .blocks = {}};
        layout.common.push_back({state_.tasks[0].study.space.axes.size(), {}});
        const double towards = effect.score > 0.0 ? 1.0 : 0.0;
        for (const std::size_t i : state_.members) {
            for (const study::Variant& variant : effects_of_road(state_.tasks[i].study)) {
                if (key_of(variant, state_.tasks[i].study) == key) {
                    tasks.push_back(with_effects(state_.tasks[i], {variant}, problem_of_));
                    runs.push_back(session_.begin(tasks.back().study, "road-effect", tasks.back().words()));
                    points.push_back(state_.points[i]);
                    constexpr double begun = 0.1; // of the way to the end of its range
                    points.back().unit.push_back((1.0 - begun) * axis.unit(axis.start) + begun * towards);
                    layout.blocks.push_back(state_.layout.blocks[i]);
                    layout.blocks.back().common.push_back(size);
                    break;
                }
            }
        }
        std::vector<std::size_t> all(tasks.size());
        std::iota(all.begin(), all.end(), std::size_t{0});
        RoadStations stations(session_, tasks, runs, layout);
        const auto end = stations.search_together(all, points, fit_number);
        if (!end) {
            return false;
        }
        if (end->search.unit.empty() || tasks.size() < members()) {
            return true; // no answer with it, or not every station can have it
        }
        double chi2 = 0.0;
        for (const double squares : end->search.squares) {
            chi2 += squares;
        }
        judge(effect, chi2);
        const double unit = end->search.unit[0].back();
        effect.size = axis.physical(unit);
        const auto covariance = optimise::arrow_covariance(end->blocks, end->search.normal).common;
        // The common unknowns stand in the order of the layout.
        const double deviation = std::sqrt(covariance(size, size));
        const double half = inference::two_sided_95 * deviation;
        effect.low = axis.physical(std::max(0.0, unit - half));
        effect.high = axis.physical(std::min(1.0, unit + half));
        effect.ends_range =
            inference::reaches_end(unit, half, axis.unit(axis.start), first.applied.effect->high_is_limit);
        effect.log_evidence = road_evidence(effect.kind, chi2, result_.dof, axis,
                                            first.typical.value_or(first.applied.effect->typical), unit, deviation);
        auto applied = first.applied;
        applied.size = effect.size;
        effect.words = first.applied.effect->in_words(applied);
        constexpr std::string_view some = "the sensor ";
        if (lacks_[effect.candidate].offset_mm && effect.words.starts_with(some)) { // say which
            effect.words = effect.on + " " + effect.words.substr(some.size());
        }
        return true;
    }

    Session& session_;
    const RoadState& state_;
    const ProblemOfStation& problem_of_;
    std::vector<Lack> lacks_;
    std::map<std::size_t, double> promised_;                 // fall of chi2, of every candidate
    std::map<std::size_t, std::pair<double, double>> gains_; // share and its standard deviation, of every sensor
    MatrixXd directions_;                                    // cosines between candidates
    RoadDiagnosis result_;
};

} // namespace

std::optional<RoadDiagnosis> diagnose_road(Session& session, const RoadState& state, double dof,
                                           const ProblemOfStation& problem_of) {
    return Diagnoser(session, state, dof, problem_of).run();
}

} // namespace explore::analysis
