#include "analysis/road/road_diagnosis.h"

#include "analysis/road/road_decision.h"
#include "base/text.h"
#include "base/units.h"
#include "diagnose/screening.h"
#include "inference/quantiles.h"
#include "pavement/effects/effect.h"
#include "study/variants.h"

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
// Each run of it is a march in time.
const std::vector<std::string> without = {"inertia"};

// Something that the road may lack.
struct Lack {
    std::optional<study::Variant> variant{}; // at the first station that has it; none: the scale of a sensor
    std::optional<double> offset_mm{};       // of the sensor that it concerns
    int sense = 0;                           // of its sizes: 1 above the null, -1 below, 0 both
    std::vector<VectorXd> change;            // of every member's residuals by its size, unit coordinate or share
};

double x_mm(const study::Study& study, int reading) {
    return study.readings[static_cast<std::size_t>(reading)].x_mm;
}

std::string key_of(const study::Variant& variant, const study::Study& study) {
    std::string key(variant.applied.effect->name);
    if (variant.applied.reading) {
        key += fmt::format(" {}", x_mm(study, *variant.applied.reading));
    }
    return variant.applied.offsets.empty() ? key : key + " " + variant.on;
}

// Effects that all stations can lack alike: on every load, or at the place of a sensor.
bool is_of_the_road(const study::Variant& variant) {
    const auto& applied = variant.applied;
    return !applied.load && !applied.quantity && !applied.effect->is_error_of_reading;
}

// The task with effects of free size.
StationTask with_effects(const StationTask& task, const std::vector<study::Variant>& variants,
                         const ProblemOfStation& problem_of) {
    StationTask extended = task;
    extended.study = study::with_free_effects(task.study, variants);
    for (std::size_t k = task.study.space.axes.size(); k < extended.study.space.axes.size(); ++k) {
        extended.study.space.axes[k].level = problem::Level::shared;
    }
    extended.problem = problem_of(extended.study);
    return extended;
}

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
        if (!differentiate() || !move_sensors()) {
            return std::nullopt;
        }
        add_sensors();
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

    // Of the residuals of every member by the size of every effect, at none. False: interrupted.
    bool differentiate() {
        std::vector<StationTask> tasks;
        std::vector<int> runs;
        std::vector<std::vector<study::Variant>> of_member;
        std::map<std::string, std::size_t> places;
        for (const std::size_t i : state_.members) {
            std::vector<study::Variant> mine;
            for (study::Variant& variant : study::variants(state_.tasks[i].study, without)) {
                if (is_of_the_road(variant) && !variant.applied.reading) {
                    mine.push_back(std::move(variant));
                }
            }
            tasks.push_back(with_effects(state_.tasks[i], mine, problem_of_));
            runs.push_back(session_.begin(tasks.back().study, "road-effects", tasks.back().words()));
            for (const study::Variant& variant : mine) {
                const std::string key = key_of(variant, state_.tasks[i].study);
                const auto [at, is_new] = places.try_emplace(key, lacks_.size());
                if (is_new) {
                    const auto& effect = *variant.applied.effect;
                    Lack lack{.variant = variant,
                              .sense = effect.null <= effect.low    ? 1
                                       : effect.null >= effect.high ? -1
                                                                    : 0,
                              .change = std::vector<VectorXd>(members())};
                    lacks_.push_back(std::move(lack));
                }
            }
            of_member.push_back(std::move(mine));
        }
        const RoadLayout layout; // nothing is searched
        RoadStations stations(session_, tasks, runs, layout);
        return stations.for_each(members(), [&](std::size_t m) {
            const RoadPoint& point = state_.points[state_.members[m]];
            const auto d = static_cast<Index>(point.unit.size());
            std::vector<double> unit = point.unit;
            for (const study::Variant& variant : of_member[m]) {
                unit.push_back(study::size_axis(*variant.applied.effect).unit(variant.applied.effect->null));
            }
            const auto here = stations.search(m, unit, {}, 0);
            if (!here || !here->evaluation.converged()) {
                return;
            }
            const problem::Problem& problem = tasks[m].problem;
            const MatrixXd slopes = problem.residual_jacobian(here->evaluation);
            const VectorXd residuals = problem.residuals(here->evaluation);
            for (std::size_t v = 0; v < of_member[m].size(); ++v) {
                const auto& effect = *of_member[m][v].applied.effect;
                const std::size_t at = unit.size() - of_member[m].size() + v;
                VectorXd change = slopes.col(d + static_cast<Index>(v));
                constexpr double nothing = 1e-9; // no slope at none: the size counts by its square, or by its step
                if (change.allFinite() && change.norm() < nothing) {
                    std::vector<double> there = unit;
                    there[at] = study::size_axis(effect).unit(of_member[m][v].typical.value_or(effect.typical));
                    const auto away = stations.search(m, there, {}, 1 + static_cast<int>(v));
                    if (away && away->evaluation.converged()) {
                        change = (problem.residuals(away->evaluation) - residuals) / (there[at] - unit[at]);
                    }
                }
                if (change.allFinite()) {
                    lacks_[places.at(key_of(of_member[m][v], state_.tasks[state_.members[m]].study))].change[m] =
                        change;
                }
            }
        });
    }

    // Of the residuals by the places of sensors: all stand a little farther out, which changes nothing but what each
    // reads itself. False: interrupted.
    bool move_sensors() {
        constexpr double step_mm = 1.0;
        std::vector<StationTask> tasks;
        std::vector<int> runs;
        std::vector<std::map<double, Lack>> found(members());
        for (const std::size_t i : state_.members) {
            tasks.push_back(state_.tasks[i]);
            StationTask& moved = tasks.back();
            for (auto& sensor : moved.study.model.sensors) {
                sensor.x += step_mm * pave::unit::mm;
            }
            moved.study.hash += " sensors moved";
            moved.problem = problem_of_(moved.study);
            runs.push_back(session_.begin(moved.study, "road-sensors", moved.words()));
        }
        const RoadLayout layout; // nothing is searched
        RoadStations stations(session_, tasks, runs, layout);
        const bool finished = stations.for_each(members(), [&](std::size_t m) {
            const StationTask& task = state_.tasks[state_.members[m]];
            const RoadPoint& point = state_.points[state_.members[m]];
            const auto there = stations.search(m, point.unit, {}, 0);
            if (!there || !there->evaluation.converged()) {
                return;
            }
            const VectorXd by_step =
                task.problem.standard_residuals(there->evaluation) - task.problem.standard_residuals(point.evaluation);
            for (const study::Variant& variant : study::variants(task.study, without)) {
                if (!is_of_the_road(variant) || !variant.applied.reading) {
                    continue;
                }
                const auto& effect = *variant.applied.effect;
                const double offset = x_mm(task.study, *variant.applied.reading);
                Lack& lack = found[m][offset];
                lack.variant = variant;
                lack.offset_mm = offset;
                VectorXd change = VectorXd::Zero(static_cast<Index>(task.problem.rows()));
                for (std::size_t row = 0; row < task.problem.readings(); ++row) {
                    if (x_mm(task.study, static_cast<int>(task.problem.response_of(row))) == offset) {
                        change += by_step[static_cast<Index>(row)] / step_mm * (effect.high - effect.low) *
                                  task.problem.change_by(row);
                    }
                }
                lack.change = {std::move(change)};
            }
        });
        std::map<double, Lack> all;
        for (std::size_t m = 0; m < members(); ++m) {
            for (auto& [offset, lack] : found[m]) {
                VectorXd change = std::move(lack.change[0]);
                Lack& of_road = all.try_emplace(offset, std::move(lack)).first->second;
                of_road.change.resize(members());
                of_road.change[m] = std::move(change);
            }
        }
        for (auto& [offset, lack] : all) {
            lacks_.push_back(std::move(lack));
        }
        return finished;
    }

    // A sensor that reads a share too much everywhere.
    void add_sensors() {
        std::map<double, Lack> sensors;
        for (std::size_t m = 0; m < members(); ++m) {
            const StationTask& task = state_.tasks[state_.members[m]];
            std::size_t row = 0; // readings stand in the order of the bowls
            for (const auto* bowl : task.bowls()) {
                for (const auto& reading : bowl->readings) {
                    Lack& lack = sensors[reading.offset_mm];
                    lack.offset_mm = reading.offset_mm;
                    lack.change.resize(members());
                    VectorXd& change = lack.change[m];
                    const VectorXd by_reading =
                        task.problem.change_by_gain(row, state_.points[state_.members[m]].evaluation);
                    change = change.size() > 0 ? VectorXd(change + by_reading) : by_reading;
                    ++row;
                }
            }
        }
        for (auto& [offset, lack] : sensors) {
            lacks_.push_back(std::move(lack));
        }
    }

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
            for (const study::Variant& variant : study::variants(state_.tasks[i].study, without)) {
                if (is_of_the_road(variant) && key_of(variant, state_.tasks[i].study) == key) {
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
        const double none = axis.unit(axis.start);
        effect.ends_range = (unit - half <= 0.0 && none > 0.0) || (unit + half >= 1.0 && none < 1.0);
        effect.log_evidence = road_evidence(effect.kind, chi2, result_.dof, axis,
                                            first.typical.value_or(first.applied.effect->typical), unit, deviation);
        auto applied = first.applied;
        applied.size = effect.size;
        effect.words = first.applied.effect->in_words(applied);
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
