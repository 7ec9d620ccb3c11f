#include "analysis/diagnose/separating.h"

#include "inference/quantiles.h"
#include "pavement/effects/effect.h"
#include "study/candidates.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <map>
#include <set>

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

namespace {

// An instrument that an explanation doubts: further readings by it are as wrong. Of one at one place those at that
// place, else all of its quantity.
class DoubtedInstrument {
public:
    // list: of the readings that may follow; what the variant itself changes of them is not told again.
    DoubtedInstrument(const study::Study& study, const study::Study& list, const study::Variant& variant) {
        if (variant.applied.reading) { // a wrong reading is no property of the next one
            return;
        }
        const auto changed = pave::pavement::readings_changed_alone(study.model, variant.applied);
        is_scaled_ = changed.are_scaled;
        const auto told = pave::pavement::readings_changed_alone(list.model, variant.applied);
        told_.insert(told.sensors.begin(), told.sensors.end());
        for (const std::size_t row : changed.sensors) {
            places_[study.readings[row].quantity].insert(study.readings[row].place_words());
        }
    }

    bool reads(const study::Study& list, std::size_t row) const {
        const data::Reading& reading = list.readings[row];
        const auto at = places_.find(reading.quantity);
        return !told_.contains(row) && at != places_.end() &&
               (at->second.size() > 1 || at->second.contains(reading.place_words()));
    }
    bool is_scaled() const { return is_scaled_; } // by the size of the variant; else nobody knows what it reads

private:
    std::map<std::string, std::set<std::string>> places_; // of each quantity
    std::set<std::size_t> told_;                          // rows of the list
    bool is_scaled_ = false;
};

} // namespace

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
    std::vector<char> is_unknown(list.readings.size(), 0); // what some explanation's instrument would read
    const auto is_again = [&](std::size_t i) { return i + suspected.size() >= list.readings.size(); };
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
        std::vector<DoubtedInstrument> instruments;
        for (const study::Variant& variant : own) {
            instruments.emplace_back(study, list, variant);
        }
        for (std::size_t i = 0; i < list.readings.size(); ++i) {
            Eigen::VectorXd slope(static_cast<Eigen::Index>(columns.size()));
            for (std::size_t k = 0; k < columns.size(); ++k) {
                const auto at = static_cast<std::size_t>(columns[k]);
                slope[static_cast<Eigen::Index>(k)] =
                    outcome->jacobian(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) *
                    fitted->space.axes[at].d_physical(model.unit[at]);
            }
            for (std::size_t v = 0; v < own.size() && !is_again(i); ++v) { // again: by another instrument
                if (!instruments[v].reads(list, i)) {
                    continue;
                }
                const double size = values[baseline + v];
                const auto at = static_cast<std::size_t>(columns[baseline + v]);
                is_unknown[i] |= instruments[v].is_scaled() ? 0 : 1;
                slope *= size;
                slope[static_cast<Eigen::Index>(baseline + v)] +=
                    f.values[i] * fitted->space.axes[at].d_physical(model.unit[at]);
                f.values[i] *= size;
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
        if (is_unknown[i] != 0) {
            continue;
        }
        reading.noise.absolute = study::candidate_noise(list.model.sensors[i].quantity, predicted[0].values[i]);
        const double noise = reading.noise.absolute;
        SeparatingReading s{.reading = std::move(reading),
                            .again = is_again(i),
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
