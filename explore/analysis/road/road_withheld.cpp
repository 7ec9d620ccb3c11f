#include "analysis/road/road_withheld.h"

#include "base/error.h"

#include <Eigen/Cholesky>
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

// The withheld readings of a station against its prediction.
struct Predicted {
    std::vector<double> offset_mm;
    VectorXd deviation; // ln(measured / predicted) of each
    VectorXd fitted;    // of the same sensor at the nearest level that was fitted; not a number: it did not read there
    VectorXd at_lowest, at_highest; // and at the lowest and the highest of them
    double step = 0.0;              // ln of the pressure over that of the nearest level that was fitted
    VectorXd noise;                 // standard deviation of the reading as a share of it
    MatrixXd by_common;             // d(ln predicted)/d(common unknowns), the station's own following
    MatrixXd spread;                // covariance of ln(predicted) by the fit
    double chi2 = 0.0;
};

Predicted predicted_at(const RoadState& state, std::size_t i, const study::Study& study,
                       const problem::Problem& problem, const problem::Evaluation& e, const MatrixXd& common,
                       double noise_factor) {
    const StationInformation station(state, i);
    const MatrixXd covariance = station.covariance(common) * noise_factor * noise_factor;
    const auto n = static_cast<Index>(problem.readings());
    Predicted p{.offset_mm = {},
                .deviation = VectorXd(n),
                .fitted = VectorXd::Constant(n, NAN),
                .at_lowest = VectorXd::Constant(n, NAN),
                .at_highest = VectorXd::Constant(n, NAN),
                .noise = VectorXd(n),
                .by_common = MatrixXd::Zero(n, common.rows()),
                .spread = {}};
    MatrixXd logarithmic(n, covariance.rows());
    for (Index r = 0; r < n; ++r) {
        const std::size_t response = problem.response_of(static_cast<std::size_t>(r));
        const double model = e.responses[response];
        p.offset_mm.push_back(study.readings[response].x_mm);
        p.noise[r] = noise_factor * study.readings[response].noise.deviation(model) / model;
        p.deviation[r] = std::log(problem.measured(static_cast<std::size_t>(r)) / model);
        for (Index k = 0; k < covariance.rows(); ++k) {
            const auto axis = static_cast<std::size_t>(k);
            logarithmic(r, k) = e.jacobian(static_cast<Index>(response), k) *
                                problem.space.axes[axis].d_physical(state.points[i].unit[axis]) / model;
        }
    }
    p.spread = logarithmic * covariance * logarithmic.transpose();
    const MatrixXd along =
        logarithmic(Eigen::all, station.shared) + logarithmic(Eigen::all, station.own) * station.following;
    for (std::size_t c = 0; c < station.to.size(); ++c) {
        p.by_common.col(station.to[c]) = along.col(static_cast<Index>(c));
    }
    // In units of noise, where readings are independent.
    const MatrixXd jacobian = problem.residual_jacobian(e).topRows(n);
    const VectorXd residuals = problem.residuals(e).head(n);
    MatrixXd variance = jacobian * covariance * jacobian.transpose();
    variance.diagonal().array() += noise_factor * noise_factor;
    p.chi2 = residuals.dot(variance.llt().solve(residuals));
    return p;
}

// ln(measured / model) of a sensor at the levels that were fitted, with their pressures [kPa]; rising.
std::vector<std::pair<double, double>> fitted_deviations(const StationTask& task, const problem::Evaluation& e,
                                                         double offset_mm) {
    std::vector<std::pair<double, double>> found;
    std::size_t row = 0; // readings stand in the order of the bowls
    for (const data::DeflectionBowl* bowl : task.bowls()) {
        for (const data::BowlReading& reading : bowl->readings) {
            if (reading.offset_mm == offset_mm) {
                found.emplace_back(bowl->pressure_kPa,
                                   std::log(task.problem.measured(row) / e.responses[task.problem.response_of(row)]));
            }
            ++row;
        }
    }
    std::sort(found.begin(), found.end());
    return found;
}

// The residuals of the fit at the sensors of a withheld bowl, whose first reading is this row.
void compare_with_fitted(const StationTask& task, const problem::Evaluation& e, const data::DeflectionBowl& bowl,
                         Index row, Predicted& p) {
    for (const data::BowlReading& reading : bowl.readings) {
        const auto levels = fitted_deviations(task, e, reading.offset_mm);
        if (!levels.empty()) {
            const auto distance = [&](const auto& level) {
                return std::abs(std::log(level.first / bowl.pressure_kPa));
            };
            const auto nearest = std::min_element(
                levels.begin(), levels.end(), [&](const auto& x, const auto& y) { return distance(x) < distance(y); });
            p.fitted[row] = nearest->second;
            p.at_lowest[row] = levels.front().second;
            p.at_highest[row] = levels.back().second;
            p.step = std::log(bowl.pressure_kPa / nearest->first);
        }
        ++row;
    }
}

void add_sensors(const std::vector<Predicted>& all, const MatrixXd& common, WithheldLevel& level) {
    std::map<double, std::vector<std::pair<const Predicted*, Index>>> at;
    for (const Predicted& p : all) {
        for (std::size_t r = 0; r < p.offset_mm.size(); ++r) {
            at[p.offset_mm[r]].emplace_back(&p, static_cast<Index>(r));
        }
    }
    for (const auto& [offset, readings] : at) {
        const auto n = static_cast<double>(readings.size());
        if (readings.size() < 3) {
            continue;
        }
        double mean = 0.0;
        Eigen::RowVectorXd by_common = Eigen::RowVectorXd::Zero(common.rows());
        for (const auto& [p, r] : readings) {
            mean += p->deviation[r] / n;
            by_common += p->by_common.row(r) / n;
        }
        double squares = 0.0;
        for (const auto& [p, r] : readings) {
            squares += std::pow(p->deviation[r] - mean, 2);
        }
        const double error = std::sqrt(squares / (n - 1.0) / n + (by_common * common * by_common.transpose()).value());
        // Without the residuals of the fit at this sensor anyway.
        std::vector<double> change;
        double fitted = 0.0;
        double at_lowest = 0.0;
        double at_highest = 0.0;
        for (const auto& [p, r] : readings) {
            if (std::isfinite(p->fitted[r])) {
                change.push_back(p->deviation[r] - p->fitted[r]);
                fitted += p->fitted[r];
                at_lowest += p->at_lowest[r];
                at_highest += p->at_highest[r];
            }
        }
        level.sensors.push_back({.offset_mm = offset,
                                 .stations = readings.size(),
                                 .mean_percent = 100.0 * std::expm1(mean),
                                 .error_percent = 100.0 * error,
                                 .p_familywise = 2.0 * gsl_cdf_tdist_Q(std::abs(mean) / error, n - 1.0)});
        if (change.size() >= 3) {
            auto& sensor = level.sensors.back();
            const auto m = static_cast<double>(change.size());
            const double middle = std::accumulate(change.begin(), change.end(), 0.0) / m;
            double scatter = 0.0;
            for (const double c : change) {
                scatter += std::pow(c - middle, 2) / (m - 1.0) / m;
            }
            sensor.fitted_percent = 100.0 * std::expm1(fitted / m);
            constexpr double alike = 1.0 / 3.0;
            const auto is_off = [&](double there) {
                return there * mean > 0.0 && std::abs(there / m) > alike * std::abs(mean);
            };
            sensor.is_off_at_all_levels = is_off(at_lowest) && is_off(at_highest);
            sensor.load_percent = 100.0 * std::expm1(middle);
            sensor.load_error_percent = 100.0 * std::sqrt(scatter);
            sensor.load_p_familywise = 2.0 * gsl_cdf_tdist_Q(std::abs(middle) / std::sqrt(scatter), m - 1.0);
        }
    }
    std::vector<double*> p;
    std::vector<double*> by_load;
    for (auto& sensor : level.sensors) {
        p.push_back(&sensor.p_familywise);
        by_load.push_back(&sensor.load_p_familywise);
    }
    holm(p);
    holm(by_load);
}

} // namespace

std::vector<WithheldBowls> withhold(SurveyResult& survey, const LoadLevel& level) {
    constexpr double near = 0.1;
    std::vector<WithheldBowls> withheld;
    for (std::size_t i = 0; i < survey.stations.size(); ++i) {
        StationResult& s = survey.stations[i];
        if (!s.has_bowl()) {
            continue;
        }
        WithheldBowls out{i, {}};
        std::vector<data::DeflectionBowl> kept;
        for (data::DeflectionBowl& bowl : s.bowls->levels) {
            const double wanted = level.pressure_on(bowl.radius_mm);
            (std::abs(bowl.pressure_kPa / wanted - 1.0) <= near ? out.bowls : kept).push_back(bowl);
        }
        if (out.bowls.empty()) {
            continue;
        }
        if (kept.empty()) {
            s.state = StationState::failed;
            s.reason = "no load level is left to fit";
            continue;
        }
        s.bowls->levels = std::move(kept);
        s.bowls->main = std::min(s.bowls->main, s.bowls->levels.size() - 1);
        withheld.push_back(std::move(out));
    }
    if (withheld.empty()) {
        throw pave::Error(
            {.key = "--withhold"}, "no station has a load level near this one and another to be fitted to",
            level.pressure_kPa ? fmt::format("{:g} kPa", *level.pressure_kPa) : fmt::format("{:g} kN", *level.force_kN),
            "one of several load levels");
    }
    return withheld;
}

std::optional<WithheldLevel> predict(const RoadState& state, const SurveyResult& survey,
                                     const std::vector<WithheldBowls>& withheld,
                                     const std::function<problem::Problem(const study::Study&)>& make_problem,
                                     double noise_factor) {
    const MatrixXd common = common_covariance(state);
    std::vector<std::optional<Predicted>> found(state.members.size());
    const bool finished = state.stations.for_each(state.members.size(), [&](std::size_t m) {
        const std::size_t i = state.members[m];
        const auto station = static_cast<std::size_t>(state.tasks[i].station - survey.stations.data());
        const auto mine = std::find_if(withheld.begin(), withheld.end(),
                                       [&](const WithheldBowls& w) { return w.station == station; });
        if (mine == withheld.end()) {
            return;
        }
        std::vector<const data::DeflectionBowl*> bowls;
        for (const data::DeflectionBowl& bowl : mine->bowls) {
            bowls.push_back(&bowl);
        }
        const study::Study study =
            study::station_study(*survey.study, state.tasks[i].station->station, bowls, survey.repeatability);
        const problem::Problem problem = make_problem(study);
        const auto workspace = problem.function->make_workspace();
        const problem::Evaluation e = problem.evaluate(state.points[i].unit, true, *workspace);
        if (e.converged()) {
            found[m] = predicted_at(state, i, study, problem, e, common, noise_factor);
            Index row = 0;
            for (const data::DeflectionBowl* bowl : bowls) {
                compare_with_fitted(state.tasks[i], state.points[i].evaluation, *bowl, row, *found[m]);
                row += static_cast<Index>(bowl->readings.size());
            }
        }
    });
    if (!finished) {
        return std::nullopt;
    }
    WithheldLevel level;
    std::vector<Predicted> all;
    double squares = 0.0;
    double expected = 0.0;
    for (auto& p : found) {
        if (!p) {
            continue;
        }
        ++level.stations;
        level.readings += p->offset_mm.size();
        level.chi2 += p->chi2;
        squares += p->deviation.squaredNorm();
        expected += p->noise.squaredNorm() + p->spread.trace();
        level.step += p->step;
        all.push_back(std::move(*p));
    }
    if (level.readings > 0) {
        const auto n = static_cast<double>(level.readings);
        level.rms_percent = 100.0 * std::sqrt(squares / n);
        level.noise_percent = 100.0 * std::sqrt(expected / n);
        level.p_value = gsl_cdf_chisq_Q(level.chi2, n);
        add_sensors(all, common * noise_factor * noise_factor, level);
    }
    return level;
}

} // namespace explore::analysis
