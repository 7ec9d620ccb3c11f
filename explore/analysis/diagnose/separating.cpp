#include "analysis/diagnose/separating.h"

#include "inference/quantiles.h"
#include "pavement/effects/effect.h"
#include "study/candidates.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>

namespace explore::analysis {

using diagnose::Diagnosis;

std::vector<std::size_t> suspected_readings(const std::vector<study::Variant>& all, const Diagnosis& d,
                                            std::size_t most) {
    std::vector<std::size_t> rows;
    for (std::size_t e = 0; e < std::min(most, d.to_compare().size()); ++e) {
        for (const std::size_t member : d.to_compare()[e].fit.model.members) {
            const auto& applied = all[member].applied;
            const auto row = applied.reading ? static_cast<std::size_t>(*applied.reading) : 0;
            if (applied.reading && std::find(rows.begin(), rows.end(), row) == rows.end()) {
                rows.push_back(row);
            }
        }
    }
    return rows;
}

std::vector<SeparatingReading> separating_readings(const study::Study& study, const std::vector<study::Variant>& all,
                                                   diagnose::Workbench& bench, const Diagnosis& d) {
    constexpr std::size_t most = 6;
    const std::vector<std::size_t> suspected = suspected_readings(all, d, most);
    const study::Study list = study::candidates(study, suspected);
    struct Predicted {
        std::vector<double> values, variances;
    };
    std::vector<Predicted> predicted;
    std::vector<std::size_t> compared;
    for (std::size_t e = 0; e < std::min(most, d.to_compare().size()); ++e) {
        const auto& model = d.to_compare()[e].fit.model;
        // A wrong reading is no property of the next one.
        std::vector<study::Variant> own;
        std::vector<double> values = model.evaluation.parameters;
        std::vector<Eigen::Index> columns;
        const std::size_t baseline = study.space.axes.size();
        values.resize(baseline);
        for (std::size_t k = 0; k < baseline; ++k) {
            columns.push_back(static_cast<Eigen::Index>(k));
        }
        for (std::size_t m = 0; m < model.members.size(); ++m) {
            const study::Variant& variant = all[model.members[m]];
            if (!variant.applied.reading && why_impossible(list.model, variant.applied).empty()) {
                own.push_back(variant);
                values.push_back(model.evaluation.parameters[baseline + m]);
                columns.push_back(static_cast<Eigen::Index>(baseline + m));
            }
        }
        const problem::Problem problem = study::make_prediction_problem(study::with_free_effects(list, own));
        const auto workspace = problem.function->make_workspace();
        const auto outcome = problem.function->evaluate(values, true, *workspace);
        if (!outcome) {
            continue;
        }
        const auto fitted = bench.problem(model.members);
        const Eigen::MatrixXd j = fitted->residual_jacobian(model.evaluation);
        Eigen::MatrixXd h = j.transpose() * j / d.variance;
        h.diagonal().array() += 1.0 / inference::box_variance;
        const Eigen::MatrixXd covariance = h.inverse();
        Predicted f{outcome->responses, {}};
        for (std::size_t i = 0; i < list.readings.size(); ++i) {
            Eigen::VectorXd slope(static_cast<Eigen::Index>(columns.size()));
            for (std::size_t k = 0; k < columns.size(); ++k) {
                const auto at = static_cast<std::size_t>(columns[k]);
                slope[static_cast<Eigen::Index>(k)] =
                    outcome->jacobian(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) *
                    fitted->space.axes[at].d_physical(model.unit[at]);
            }
            const Eigen::MatrixXd part = covariance(columns, columns);
            f.variances.push_back(slope.dot(part * slope));
        }
        predicted.push_back(std::move(f));
        compared.push_back(e);
    }
    std::vector<SeparatingReading> readings;
    if (predicted.size() < 2) {
        return readings;
    }
    for (std::size_t i = 0; i < list.readings.size(); ++i) {
        data::Reading reading = list.readings[i];
        reading.noise.absolute = study::candidate_noise(list.model.sensors[i].quantity, predicted[0].values[i]);
        const double noise = reading.noise.absolute;
        SeparatingReading s{.reading = std::move(reading),
                            .again = i + suspected.size() >= list.readings.size(),
                            .explanations = compared,
                            .values = {},
                            .power = 1.0,
                            .rate_now = 1.0};
        for (std::size_t e = 0; e < predicted.size(); ++e) {
            s.values.push_back(s.reading.in_unit(predicted[e].values[i]));
            if (e == 0) {
                continue;
            }
            // Now: the difference of chi2; the new reading adds its own.
            const double now = std::max(0.0, d.to_compare()[compared[e]].behind);
            const double more = std::pow(predicted[e].values[i] - predicted[0].values[i], 2) /
                                (noise * noise + predicted[0].variances[i] + predicted[e].variances[i]);
            s.power = std::min(s.power, gsl_cdf_ugaussian_P(std::sqrt(now + more) / 2.0));
            s.rate_now = std::min(s.rate_now, gsl_cdf_ugaussian_P(std::sqrt(now) / 2.0));
        }
        readings.push_back(std::move(s));
    }
    std::stable_sort(readings.begin(), readings.end(), [](const auto& a, const auto& b) { return a.power > b.power; });
    std::stable_partition(readings.begin(), readings.end(),
                          [&](const auto& own) { return is_at_hand(study, own.reading); });
    return readings;
}

} // namespace explore::analysis
