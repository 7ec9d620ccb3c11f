#include "analysis/survey/survey_sensors.h"

#include "data/median.h"
#include "landscape/minima.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <map>

namespace explore::analysis {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double p_of_one_sign = 0.01;
constexpr std::size_t needed = 8; // stations

// p of so many of one sign or more, two-sided.
double sign_test(std::size_t same, std::size_t all) {
    return 2.0 * gsl_cdf_binomial_Q(static_cast<unsigned>(same) - 1, 0.5, static_cast<unsigned>(all));
}

// ln(model / measured) of the highest level that was fitted at a station; empty: the model has no logarithm there.
struct LevelResiduals {
    std::vector<double> offset_mm, deflection_um, residual;
};
LevelResiduals residuals_of(const StationResult& s) {
    const std::size_t last = s.fit->levels.size() - 1;
    const auto& readings = s.bowls->levels[s.fit->levels[last]].readings;
    const auto& model = s.fit->model_um[last];
    LevelResiduals found;
    for (std::size_t i = 0; i < readings.size(); ++i) {
        if (!(model[i] > 0.0)) {
            return {};
        }
        found.offset_mm.push_back(readings[i].offset_mm);
        found.deflection_um.push_back(readings[i].deflection_um);
        found.residual.push_back(std::log(model[i] / readings[i].deflection_um));
    }
    return found;
}

// The median and the scatter about it of the residuals of a sensor or a level of load, and whether its sign is due to
// chance, among so many.
template <class Residual>
void judge(const std::vector<double>& values, std::size_t among, Residual& of) {
    constexpr double worth_saying = 1.0; // percent
    const double middle = data::median(values);
    std::vector<double> off;
    for (const double value : values) {
        off.push_back(std::abs(value - middle));
    }
    of.stations = values.size();
    of.percent = 100.0 * std::expm1(middle);
    of.scatter_percent = 100.0 * 1.4826 * data::median(off);
    of.above = static_cast<std::size_t>(std::count_if(values.begin(), values.end(), [](double r) { return r > 0.0; }));
    const std::size_t same = std::max(of.above, values.size() - of.above);
    of.one_sign = values.size() >= needed && std::abs(of.percent) >= worth_saying &&
                  sign_test(same, values.size()) * static_cast<double>(among) < p_of_one_sign;
}

std::vector<SensorResidual> judged(const std::map<double, std::vector<double>>& residuals) {
    std::vector<SensorResidual> found;
    for (const auto& [offset, values] : residuals) {
        SensorResidual sensor{.offset_mm = offset};
        judge(values, residuals.size(), sensor);
        found.push_back(sensor);
    }
    return found;
}

// The residuals of a station's fit where this sensor is left out, to first order; empty: it cannot be told.
VectorXd without(const StationResult& s, const LevelResiduals& here, std::size_t sensor) {
    const auto& best = s.fit->best;
    const auto& e = best.evaluation;
    const auto n = static_cast<Index>(here.residual.size());
    Index begin = 0; // of the last level; outputs may follow
    for (std::size_t l = 0; l + 1 < s.fit->model_um.size(); ++l) {
        begin += static_cast<Index>(s.fit->model_um[l].size());
    }
    if (e.jacobian.rows() != static_cast<Index>(e.responses.size()) || begin + n > e.jacobian.rows()) {
        return {};
    }
    VectorXd weight(n);
    VectorXd residual(n);
    std::vector<VectorXd> columns;
    for (Index i = 0; i < n; ++i) {
        const auto k = static_cast<std::size_t>(i);
        weight[i] = 1.0 / std::hypot(0.01, 1.0 / here.deflection_um[k]); // 1 % and 1 um
        residual[i] = here.residual[k];
    }
    for (Index k = 0; k < e.jacobian.cols(); ++k) {
        const bool is_held = std::any_of(best.on_bound.begin(), best.on_bound.end(),
                                         [&](const auto& bound) { return static_cast<Index>(bound.axis) == k; });
        VectorXd column(n);
        for (Index i = 0; i < n; ++i) {
            column[i] = e.jacobian(begin + i, k) / e.responses[static_cast<std::size_t>(begin + i)];
        }
        if (const double norm = column.norm(); !is_held && norm > 0.0) {
            columns.emplace_back(column / norm);
        }
    }
    if (n < static_cast<Index>(columns.size()) + 3) {
        return {};
    }
    columns.emplace_back(VectorXd::Unit(n, static_cast<Index>(sensor)));
    MatrixXd all(n, static_cast<Index>(columns.size()));
    for (std::size_t c = 0; c < columns.size(); ++c) {
        all.col(static_cast<Index>(c)) = columns[c];
    }
    const MatrixXd weighted = weight.asDiagonal() * all;
    const VectorXd step = weighted.colPivHouseholderQr().solve(VectorXd(weight.cwiseProduct(residual)));
    return residual - all * step;
}

} // namespace

std::vector<SensorResidual> sensor_residuals(const SurveyResult& result) {
    std::map<double, std::vector<double>> residuals;
    for (const StationResult& s : result.stations) {
        if (s.is_fitted()) {
            const LevelResiduals here = residuals_of(s);
            for (std::size_t i = 0; i < here.residual.size(); ++i) {
                residuals[here.offset_mm[i]].push_back(here.residual[i]);
            }
        }
    }
    return judged(residuals);
}

std::vector<LoadResidual> load_residuals(const SurveyResult& result) {
    struct Seen {
        std::vector<double> pressure, residual;
    };
    std::map<std::size_t, Seen> seen; // by the place of the level among those of its station
    for (const StationResult& s : result.stations) {
        for (std::size_t l = 0; s.is_fitted() && s.fit->levels.size() > 1 && l < s.fit->levels.size(); ++l) {
            const auto& level = s.bowls->levels[s.fit->levels[l]];
            const auto& model = s.fit->model_um[l];
            double sum = 0.0;
            for (std::size_t i = 0; i < model.size(); ++i) {
                sum += std::log(model[i] / level.readings[i].deflection_um);
            }
            if (std::isfinite(sum)) {
                seen[l].pressure.push_back(level.pressure_kPa);
                seen[l].residual.push_back(sum / static_cast<double>(model.size()));
            }
        }
    }
    std::vector<LoadResidual> found;
    for (const auto& [level, values] : seen) {
        LoadResidual load{.pressure_kPa = data::median(values.pressure)};
        judge(values.residual, seen.size(), load);
        found.push_back(load);
    }
    return found;
}

std::optional<std::size_t> left_over_without(const SurveyResult& result, double offset_mm) {
    std::map<double, std::vector<double>> residuals;
    for (const StationResult& s : result.stations) {
        if (!s.is_fitted()) {
            continue;
        }
        const LevelResiduals here = residuals_of(s);
        const auto at = std::find(here.offset_mm.begin(), here.offset_mm.end(), offset_mm);
        if (at == here.offset_mm.end()) {
            continue;
        }
        const VectorXd left = without(s, here, static_cast<std::size_t>(at - here.offset_mm.begin()));
        for (Index i = 0; i < left.size(); ++i) {
            if (const double there = here.offset_mm[static_cast<std::size_t>(i)]; there != offset_mm) {
                residuals[there].push_back(left[i]);
            }
        }
    }
    if (residuals.empty()) {
        return std::nullopt;
    }
    const auto sensors = judged(residuals);
    return static_cast<std::size_t>(
        std::count_if(sensors.begin(), sensors.end(), [](const SensorResidual& r) { return r.one_sign; }));
}

std::optional<SuspectSensor> suspect_sensor(const SurveyResult& result) {
    constexpr double worth_saying = 0.03;
    struct Seen {
        std::vector<double> excess;   // over the neighbours
        std::vector<double> residual; // ln(model / measured)
        std::vector<double> place_mm; // where the model has that deflection
    };
    std::map<double, Seen> seen; // by offset
    for (const StationResult& s : result.stations) {
        if (!s.is_fitted()) {
            continue;
        }
        const LevelResiduals here = residuals_of(s);
        const auto& readings = s.bowls->levels[s.fit->levels.back()].readings;
        const auto& model = s.fit->model_um.back();
        const auto residual = [&](std::size_t i) { return here.residual[i]; };
        for (std::size_t i = 1; i + 1 < here.residual.size(); ++i) {
            const double width = readings[i + 1].offset_mm - readings[i - 1].offset_mm;
            const double t = (readings[i].offset_mm - readings[i - 1].offset_mm) / width;
            const double slope = std::log(model[i + 1] / model[i - 1]) / width; // of ln(model), per mm
            Seen& at = seen[readings[i].offset_mm];
            at.excess.push_back(residual(i) - (1.0 - t) * residual(i - 1) - t * residual(i + 1));
            at.residual.push_back(residual(i));
            if (slope < 0.0) {
                at.place_mm.push_back(readings[i].offset_mm - residual(i) / slope);
            }
        }
    }
    std::optional<SuspectSensor> worst;
    double worst_excess = worth_saying;
    for (const auto& [offset, at] : seen) {
        const std::size_t n = at.excess.size();
        const double middle = data::median(at.excess);
        if (n < needed || std::abs(middle) <= worst_excess) {
            continue;
        }
        const auto same = static_cast<std::size_t>(
            std::count_if(at.excess.begin(), at.excess.end(), [&](double e) { return (e > 0.0) == (middle > 0.0); }));
        const double p = std::min(1.0, sign_test(same, n) * static_cast<double>(seen.size()));
        if (p >= p_of_one_sign) {
            continue;
        }
        worst_excess = std::abs(middle);
        worst = SuspectSensor{
            .offset_mm = offset, .stations = n, .same_sign = same, .p = p, .fits_at_mm = {}, .is_beside_others = true};
        worst->model_percent = 100.0 * (std::exp(data::median(at.residual)) - 1.0);
        worst->fits_at_mm = at.place_mm.empty() ? std::nullopt : std::optional(data::median(at.place_mm));
    }
    return worst;
}

void judge_sensors(SurveyResult& result) {
    constexpr std::size_t several = 3;
    constexpr std::size_t few = 1;
    constexpr double beyond_sensors = 2.0; // percent that sensors are good to
    result.residuals = sensor_residuals(result);
    result.load_residuals = load_residuals(result);
    result.suspect = suspect_sensor(result);
    std::size_t one_sign = 0;
    double largest = 0.0;
    for (const SensorResidual& r : result.residuals) {
        one_sign += r.one_sign ? 1 : 0;
        largest = r.one_sign ? std::max(largest, std::abs(r.percent)) : largest;
    }
    if (one_sign < several || largest < beyond_sensors) {
        return;
    }
    if (result.suspect && left_over_without(result, result.suspect->offset_mm).value_or(0) <= few) {
        return;
    }
    // Whichever sensor it may be.
    std::optional<std::size_t> least;
    const SensorResidual* best = nullptr;
    for (const SensorResidual& r : result.residuals) {
        // Without the one at the centre the layer on top is free to make up for anything.
        const bool may_be = r.one_sign && r.offset_mm != 0.0;
        const auto left = may_be ? left_over_without(result, r.offset_mm) : std::nullopt;
        if (left && (!least || *left < *least)) {
            least = left;
            best = &r;
        }
    }
    if (!least) {
        return; // too few sensors: the worst one is named, with the section beside it
    }
    result.suspect.reset();
    result.section_is_suspect = *least > few;
    if (!result.section_is_suspect) {
        const std::size_t same = std::max(best->above, best->stations - best->above);
        result.suspect = SuspectSensor{
            .offset_mm = best->offset_mm,
            .stations = best->stations,
            .same_sign = same,
            .p = std::min(1.0, sign_test(same, best->stations) * static_cast<double>(result.residuals.size())),
            .model_percent = best->percent,
            .fits_at_mm = {}};
    }
}

} // namespace explore::analysis
