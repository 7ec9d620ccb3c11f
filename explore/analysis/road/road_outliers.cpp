#include "analysis/road/road_outliers.h"

#include "data/deflection_bowl.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <set>

namespace explore::analysis {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double explained = 0.01;

double p_of(double chi2, double dof, double noise_factor) {
    return dof > 0.0 ? gsl_cdf_chisq_Q(chi2 / (noise_factor * noise_factor), dof) : 0.0;
}

// Leaves out one sensor after the other: an unknown error of each of its readings beside the station's own unknowns.
void try_sensors(const RoadState& state, std::size_t i, double noise_factor, RoadOutlier& outlier) {
    const StationTask& task = state.tasks[i];
    const auto& e = state.points[i].evaluation;
    const auto bowls = task.bowls();
    std::set<double> offsets;
    for (const auto* bowl : bowls) {
        for (const auto& reading : bowl->readings) {
            offsets.insert(reading.offset_mm);
        }
    }
    const VectorXd residuals = task.problem.residuals(e);
    const MatrixXd jacobian = task.problem.residual_jacobian(e);
    const auto axes = state.layout.own_axes(i);
    for (const double offset : offsets) {
        std::vector<VectorXd> columns;
        columns.reserve(axes.size());
        double relative = 0.0;
        for (const std::size_t k : axes) {
            columns.emplace_back(jacobian.col(static_cast<Index>(k)));
        }
        std::size_t row = 0; // readings stand in the order of the bowls
        for (const auto* bowl : bowls) {
            for (const auto& reading : bowl->readings) {
                if (reading.offset_mm == offset) {
                    columns.push_back(task.problem.change_by(row));
                    relative += e.responses[task.problem.response_of(row)] / task.problem.measured(row) - 1.0;
                }
                ++row;
            }
        }
        MatrixXd all(residuals.size(), static_cast<Index>(columns.size()));
        for (std::size_t c = 0; c < columns.size(); ++c) {
            all.col(static_cast<Index>(c)) = columns[c];
        }
        const VectorXd left = residuals - all * all.colPivHouseholderQr().solve(residuals);
        const double dof = static_cast<double>(residuals.size()) - static_cast<double>(columns.size());
        const double p = p_of(left.squaredNorm(), dof, noise_factor);
        if (p > outlier.p_explained) {
            outlier.cause = OutlierCause::sensor;
            outlier.p_explained = p;
            outlier.offset_mm = offset;
            outlier.model_percent = 100.0 * relative / static_cast<double>(columns.size() - axes.size());
        }
    }
}

// The common unknown that the station by itself wants changed most, in its own standard deviations.
void try_common(const RoadState& state, std::size_t i, const RoadPoint& alone, double noise_factor,
                RoadOutlier& outlier) {
    const StationTask& task = state.tasks[i];
    const VectorXd residuals = task.problem.residuals(alone.evaluation);
    const double dof = static_cast<double>(residuals.size()) - static_cast<double>(alone.unit.size());
    const double p = p_of(residuals.squaredNorm(), dof, noise_factor);
    if (p <= outlier.p_explained) {
        return;
    }
    double most = -1.0;
    for (std::size_t k = 0; k < alone.unit.size(); ++k) {
        const double moved = std::abs(alone.unit[k] - state.points[i].unit[k]);
        if (state.layout.blocks[i].common[k] != optimise::own_unknown && moved > most) {
            most = moved;
            outlier.axis = k;
        }
    }
    if (most < 0.0) {
        return;
    }
    outlier.cause = OutlierCause::common;
    outlier.p_explained = p;
    outlier.there = alone.evaluation.parameters[outlier.axis];
    outlier.typical = state.points[i].evaluation.parameters[outlier.axis];
}

void try_neighbours(const RoadState& state, std::size_t i, RoadOutlier& outlier) {
    constexpr std::size_t reach = 5;
    constexpr std::size_t needed = 4;
    constexpr double far = 5.0;
    constexpr double worth_saying = 1.0 / 3.0;
    double worst = 0.0;
    for (const std::size_t k : state.layout.own_axes(i)) {
        std::vector<double> near;
        const auto& here = state.tasks[i].station->station;
        for (std::size_t n = i > reach ? i - reach : 0; n <= i + reach && n < state.tasks.size(); ++n) {
            const auto& there = state.tasks[n].station->station;
            if (n != i && there.profile == here.profile && there.lane == here.lane) {
                near.push_back(state.points[n].evaluation.parameters[k]);
            }
        }
        if (near.size() < needed) {
            continue;
        }
        const double middle = data::median(near);
        for (double& value : near) {
            value = std::abs(value - middle);
        }
        const double distance = std::abs(state.points[i].evaluation.parameters[k] - middle);
        const double times = distance / std::max(data::median(near), 1e-12 * std::abs(middle));
        if (times > far && distance > worth_saying * std::abs(middle) && times > worst) {
            worst = times;
            outlier.cause = OutlierCause::unlike;
            outlier.axis = k;
            outlier.there = state.points[i].evaluation.parameters[k];
            outlier.typical = middle;
        }
    }
}

} // namespace

std::vector<RoadOutlier> explain_outliers(const RoadState& state, const std::vector<RoadStation>& judged,
                                          const std::vector<RoadPoint>& alone, double noise_factor) {
    std::vector<RoadOutlier> outliers;
    for (std::size_t i = 0; i < judged.size(); ++i) {
        if (!judged[i].is_outlier) {
            continue;
        }
        RoadOutlier outlier{.station = i};
        try_sensors(state, i, noise_factor, outlier);
        try_common(state, i, alone[i], noise_factor, outlier);
        if (outlier.p_explained < explained) {
            outlier.cause = OutlierCause::not_explained;
            try_neighbours(state, i, outlier);
        }
        outliers.push_back(outlier);
    }
    return outliers;
}

} // namespace explore::analysis
