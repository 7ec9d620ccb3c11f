#include "analysis/road/road_statistics.h"

#include "analysis/road/road_course.h"
#include "data/deflection_bowl.h"
#include "inference/quantiles.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <map>
#include <numbers>

namespace explore::analysis {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double least = 1e-6; // information of an unknown that nothing tells of: a thousand boxes

// The covariance of unknowns with this information.
MatrixXd covariance_of(MatrixXd information) {
    const Index n = information.rows();
    information.diagonal().array() += least;
    return n > 0 ? MatrixXd(information.llt().solve(MatrixXd::Identity(n, n))) : information;
}

bool is_member(const RoadState& state, std::size_t i) {
    return std::find(state.members.begin(), state.members.end(), i) != state.members.end();
}

double rows(const RoadState& state, std::size_t i) {
    return static_cast<double>(state.tasks[i].problem.rows());
}

void add_common(const RoadState& state, const std::vector<RoadStation>& judged, const std::vector<MatrixXd>& by_itself,
                const MatrixXd& covariance, double quantile, RoadResult& result) {
    const auto& axes = state.tasks[0].study.space.axes;
    for (std::size_t c = 0; c < state.layout.common.size(); ++c) {
        const CommonUnknown& unknown = state.layout.common[c];
        CommonParameter parameter{.axis = unknown.axis, .section = unknown.section, .range = {}};
        const auto k = static_cast<Index>(unknown.axis);
        std::vector<double> widths;
        std::vector<double> errors;
        double unit = 0.0;
        for (const std::size_t i : state.members) {
            if (state.layout.blocks[i].common[unknown.axis] != static_cast<int>(c)) {
                continue;
            }
            unit = state.points[i].unit[unknown.axis];
            errors.push_back(std::sqrt(by_itself[i](k, k)));
            const double half = quantile * errors.back();
            widths.push_back(std::min(1.0, unit + half) - std::max(0.0, unit - half));
            parameter.alone_determined += judged[i].alone[unknown.axis].determined ? 1 : 0;
        }
        if (widths.empty()) {
            continue;
        }
        const auto at = static_cast<Index>(c);
        const double half = quantile * std::sqrt(covariance(at, at));
        parameter.range = range_about(axes[unknown.axis], unit, half);
        parameter.stations = widths.size();
        parameter.width = std::min(1.0, unit + half) - std::max(0.0, unit - half);
        parameter.alone_width = data::median(widths);
        parameter.narrower = data::median(errors) / std::sqrt(covariance(at, at));
        result.common.push_back(parameter);
    }
}

// quantile: of a single parameter, two-sided 95 %.
void add_regions(const RoadState& state, const MatrixXd& covariance, double quantile, RoadResult& result) {
    const auto& axes = state.tasks[0].study.space.axes;
    const auto unknown_of = [&](const CommonParameter& parameter) {
        const auto found = std::find_if(state.layout.common.begin(), state.layout.common.end(),
                                        [&](const auto& c) { return c.axis == parameter.axis && !c.section; });
        return static_cast<Index>(found - state.layout.common.begin());
    };
    const double reach = quantile * std::sqrt(inference::chi2_95_of_two / inference::chi2_95);
    constexpr int corners = 72;
    for (std::size_t a = 0; a < result.common.size(); ++a) {
        for (std::size_t b = a + 1; b < result.common.size(); ++b) {
            if (result.common[a].section || result.common[b].section) {
                continue;
            }
            const std::vector<Index> both{unknown_of(result.common[a]), unknown_of(result.common[b])};
            const MatrixXd factor = MatrixXd(covariance(both, both)).llt().matrixL();
            const problem::Axis& x = axes[result.common[a].axis];
            const problem::Axis& y = axes[result.common[b].axis];
            const Eigen::Vector2d centre(x.unit(result.common[a].range.value), y.unit(result.common[b].range.value));
            CommonRegion region{.a = a, .b = b};
            for (int corner = 0; corner <= corners; ++corner) {
                const double angle = 2.0 * std::numbers::pi * corner / corners;
                const Eigen::Vector2d off = reach * (factor * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
                double within = 1.0; // of the way from the answer, which is in the box
                for (const int side : {0, 1}) {
                    const double room = off[side] > 0.0 ? 1.0 - centre[side] : centre[side];
                    within = std::abs(off[side]) > room ? std::min(within, room / std::abs(off[side])) : within;
                }
                const Eigen::Vector2d point = centre + within * off;
                region.border.emplace_back(x.physical(point[0]), y.physical(point[1]));
            }
            result.regions.push_back(std::move(region));
        }
    }
}

// Of the road's own common unknowns: how well their least known combination is known.
void add_weakest(const RoadState& state, const MatrixXd& covariance, RoadResult& result) {
    std::vector<Index> shared;
    for (std::size_t c = 0; c < state.layout.common.size(); ++c) {
        if (!state.layout.common[c].section) {
            shared.push_back(static_cast<Index>(c));
        }
    }
    if (shared.empty()) {
        return;
    }
    const MatrixXd part = covariance(shared, shared);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(part);
    const Index last = part.rows() - 1;
    VectorXd direction = eigen.eigenvectors().col(last);
    Index largest = 0;
    direction.cwiseAbs().maxCoeff(&largest);
    direction *= direction[largest] < 0.0 ? -1.0 : 1.0;
    result.weakest.assign(direction.data(), direction.data() + direction.size());
    result.weakest_sd = std::sqrt(eigen.eigenvalues()[last]);
    result.condition = eigen.eigenvalues()[last] / eigen.eigenvalues()[0];
}

// Courses of the stations' own unknowns, along every lane. Errors of common unknowns are those of all stations alike
// and are added afterwards.
void add_courses(const RoadState& state, const MatrixXd& covariance, double quantile, const RoadResult& result,
                 std::vector<RoadCourse>& courses) {
    std::map<std::string, std::vector<std::size_t>> lanes;
    const auto chainage = [&](std::size_t i) { return state.tasks[i].station->station.chainage_m; };
    for (const std::size_t i : state.members) {
        const auto& station = state.tasks[i].station->station;
        if (chainage(i)) {
            lanes[station.profile.empty() ? station.lane : station.profile + " " + station.lane].push_back(i);
        }
    }
    const double scale = result.noise_factor();
    const auto& axes = state.tasks[0].study.space.axes;
    for (auto& [lane, stations] : lanes) {
        if (stations.size() < road_least_course) {
            continue;
        }
        std::stable_sort(stations.begin(), stations.end(),
                         [&](std::size_t a, std::size_t b) { return *chainage(a) < *chainage(b); });
        std::vector<StationInformation> known;
        std::vector<MatrixXd> of_all; // covariance of all axes
        for (const std::size_t i : stations) {
            known.emplace_back(state, i);
            of_all.push_back(known.back().covariance(covariance));
        }
        for (const std::size_t axis : state.layout.own_axes(stations[0])) {
            std::vector<double> at, y, variance, common;
            for (std::size_t s = 0; s < stations.size(); ++s) {
                const std::size_t i = stations[s];
                const StationInformation& information = known[s];
                const auto own = std::find(information.own.begin(), information.own.end(), static_cast<Index>(axis));
                const Index k = own - information.own.begin();
                const double alone = scale * scale * information.alone(k, k);
                const auto all = static_cast<Index>(axis);
                at.push_back(*chainage(i));
                y.push_back(state.points[i].unit[axis]);
                variance.push_back(alone);
                common.push_back(std::max(0.0, scale * scale * of_all[s](all, all) - alone));
            }
            const Course course = course_of(at, y, variance);
            RoadCourse found{.axis = axis,
                             .lane = lanes.size() > 1 ? lane : "",
                             .length_m = course.length,
                             .sd = course.sd,
                             .p_none = course.p_none,
                             .stations = stations,
                             .ranges = {}};
            std::vector<double> ratios;
            for (std::size_t s = 0; s < stations.size(); ++s) {
                const double with = std::sqrt(course.variance[s] + common[s]);
                ratios.push_back(std::sqrt(variance[s] + common[s]) / with);
                found.ranges.push_back(
                    range_about(axes[axis], std::clamp(course.value[s], 0.0, 1.0), quantile / scale * with));
            }
            found.narrower = data::median(ratios);
            courses.push_back(std::move(found));
        }
    }
}

} // namespace

StationInformation::StationInformation(const RoadState& state, std::size_t i)
    : normal(state.stations.normal(i, state.points[i])) {
    const auto& common = state.layout.blocks[i].common;
    for (std::size_t k = 0; k < common.size(); ++k) {
        if (common[k] == optimise::own_unknown) {
            own.push_back(static_cast<Index>(k));
        } else {
            shared.push_back(static_cast<Index>(k));
            to.push_back(common[k]);
        }
    }
    alone = covariance_of(normal(own, own));
    const MatrixXd across = normal(own, shared);
    following = -alone * across;
    schur = normal(shared, shared) + across.transpose() * following;
    const VectorXd gradient = state.stations.gradient(i, state.points[i]);
    pull = gradient(shared) + following.transpose() * gradient(own);
}

MatrixXd StationInformation::covariance(const MatrixXd& common) const {
    MatrixXd all(normal.rows(), normal.rows());
    const MatrixXd part = common(to, to);
    all(shared, shared) = part;
    all(own, shared) = following * part;
    all(shared, own) = part * following.transpose();
    all(own, own) = alone + following * part * following.transpose();
    return all;
}

MatrixXd common_covariance(const RoadState& state) {
    const MatrixXd known = optimise::arrow_covariance(state.end.blocks, state.end.search.normal).common;
    const auto n = static_cast<Index>(state.layout.common.size());
    MatrixXd all = MatrixXd::Identity(n, n) / least;
    all.topLeftCorner(known.rows(), known.cols()) = known;
    return all;
}

MatrixXd informed(const MatrixXd& covariance, const MatrixXd& information) {
    const Index n = covariance.rows();
    return n > 0 ? MatrixXd((MatrixXd::Identity(n, n) + covariance * information).partialPivLu().solve(covariance))
                 : covariance;
}

void holm(const std::vector<double*>& p) {
    std::vector<double*> order = p;
    std::stable_sort(order.begin(), order.end(), [](const double* a, const double* b) { return *a < *b; });
    double highest = 0.0;
    for (std::size_t k = 0; k < order.size(); ++k) {
        highest = std::max(highest, std::min(1.0, *order[k] * static_cast<double>(order.size() - k)));
        *order[k] = highest;
    }
}

double judge(const RoadState& state, std::vector<RoadStation>& judged) {
    const MatrixXd common = common_covariance(state);
    for (std::size_t i = 0; i < judged.size(); ++i) {
        RoadStation& j = judged[i];
        const StationInformation station(state, i);
        j.chi2 = state.tasks[i].problem.residuals(state.points[i].evaluation).squaredNorm();
        if (is_member(state, i)) {
            j.dof = rows(state, i) - station.covariance(common).cwiseProduct(station.normal).sum();
        } else { // what it would have left where the common unknowns moved as far as the members let them
            const MatrixXd known = common(station.to, station.to);
            j.chi2 -= station.pull.dot(informed(known, station.schur) * station.pull);
            j.dof = rows(state, i) - static_cast<double>(station.own.size());
        }
        constexpr double least = 0.5; // of a reading: less is left by rounding, and judges nothing
        j.dof = j.dof < least ? 0.0 : j.dof;
    }
    std::vector<double> ratios;
    double chi2 = 0.0;
    double dof = 0.0;
    for (const RoadStation& j : judged) {
        if (j.dof > 0.0) {
            ratios.push_back(j.chi2 / gsl_cdf_chisq_Pinv(0.5, j.dof));
            chi2 += j.chi2;
            dof += j.dof;
        }
    }
    const bool contradicts = dof > 0.0 && gsl_cdf_chisq_Q(chi2, dof) < landscape::contradicted;
    const double scale = contradicts ? std::max(1.0, data::median(ratios)) : 1.0;
    std::vector<double*> p;
    for (RoadStation& j : judged) {
        j.p_familywise = j.dof > 0.0 ? gsl_cdf_chisq_Q(j.chi2 / scale, j.dof) : 1.0;
        p.push_back(&j.p_familywise);
    }
    holm(p);
    return std::sqrt(scale);
}

void conclude(const RoadState& state, const std::vector<RoadStation>& judged, const std::vector<RoadPoint>& alone,
              RoadResult& result) {
    const auto& axes = state.tasks[0].study.space.axes;
    result.chi2 = 0.0;
    for (const double squares : state.end.search.squares) { // those of the priors too
        result.chi2 += squares;
    }
    double common_met = 0.0;
    std::vector<char> counted(state.layout.common.size(), 0);
    result.dof = 0.0;
    for (std::size_t b = 0; b < state.end.blocks.size(); ++b) {
        const auto& block = state.end.blocks[b];
        result.dof +=
            b < state.members.size() ? rows(state, state.members[b]) : static_cast<double>(block.common.size());
        for (std::size_t k = 0; k < block.common.size(); ++k) {
            const int c = block.common[k];
            const bool is_free = !landscape::is_at_bound(state.end.search.unit[b][k]);
            if (c == optimise::own_unknown) {
                result.dof -= is_free ? 1.0 : 0.0;
            } else if (counted[static_cast<std::size_t>(c)] == 0) {
                counted[static_cast<std::size_t>(c)] = 1;
                common_met += is_free ? 1.0 : 0.0;
            }
        }
    }
    result.dof -= common_met;
    result.p_value = result.dof > 0.0 ? gsl_cdf_chisq_Q(result.chi2, result.dof) : 1.0;
    result.widened = result.p_value < landscape::contradicted;
    const double quantile =
        result.widened ? gsl_cdf_tdist_Pinv(0.975, result.dof) * result.noise_factor() : inference::two_sided_95;

    result.stations = judged;
    const MatrixXd covariance = common_covariance(state);
    std::vector<MatrixXd> by_itself;
    for (std::size_t i = 0; i < state.tasks.size(); ++i) {
        by_itself.push_back(covariance_of(state.stations.normal(i, alone[i])));
        RoadStation& j = result.stations[i];
        j.chi2_alone = state.tasks[i].problem.residuals(alone[i].evaluation).squaredNorm();
        const StationInformation station(state, i);
        const MatrixXd own = station.covariance(covariance);
        StationFit& fit = *state.tasks[i].station->fit;
        for (std::size_t k = 0; k < axes.size(); ++k) {
            const auto at = static_cast<Index>(k);
            j.alone.push_back(range_about(axes[k], alone[i].unit[k], quantile * std::sqrt(by_itself.back()(at, at))));
            fit.parameters.push_back(range_about(axes[k], state.points[i].unit[k], quantile * std::sqrt(own(at, at))));
            if (j.is_outlier && state.layout.blocks[i].common[k] != optimise::own_unknown) { // common, but not its own
                fit.parameters.back().determined = false;
            }
            if (j.is_outlier && j.alone.back().determined) {
                fit.parameters.back() = j.alone.back();
            }
        }
        fit.quantile = quantile / result.noise_factor();
        fit.local.chi2 = j.chi2;
        fit.local.degrees_of_freedom = static_cast<int>(std::lround(j.dof));
        fit.local.p_value = j.dof > 0.0 ? gsl_cdf_chisq_Q(j.chi2, j.dof) : 1.0;
        fit.local.noise_is_stated = true;
        fit.local.expected_chi2 = j.dof;
        fit.local.widened = result.widened; // by the road's factor, and not by what the station would have
        fit.local.widening = result.noise_factor();
        fit.local.noise = result.noise_factor();
    }
    add_common(state, result.stations, by_itself, covariance, quantile, result);
    add_regions(state, covariance, quantile, result);
    add_weakest(state, covariance, result);
    add_courses(state, covariance, quantile, result, result.courses);

    result.conflict_chi2 = 0.0;
    result.conflict_dof = -common_met;
    double chi2_alone = 0.0;
    for (const std::size_t i : state.members) {
        const double here = state.tasks[i].problem.residuals(state.points[i].evaluation).squaredNorm();
        result.conflict_chi2 += std::max(0.0, here - result.stations[i].chi2_alone);
        chi2_alone += result.stations[i].chi2_alone;
        const auto& common = state.layout.blocks[i].common;
        result.conflict_dof += static_cast<double>(common.size() - state.layout.own_axes(i).size());
    }
    // By the noise that stations by themselves leave.
    const double alone_dof = result.dof - result.conflict_dof;
    const bool contradicts = alone_dof > 0.0 && gsl_cdf_chisq_Q(chi2_alone, alone_dof) < landscape::contradicted;
    const double scale = contradicts ? chi2_alone / alone_dof : 1.0;
    result.conflict_p =
        result.conflict_dof > 0.0 ? gsl_cdf_chisq_Q(result.conflict_chi2 / scale, result.conflict_dof) : 1.0;
}

} // namespace explore::analysis
