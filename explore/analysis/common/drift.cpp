#include "analysis/common/drift.h"

#include "base/text.h"
#include "base/units.h"
#include "inference/quantiles.h"
#include "study/readings.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace explore::analysis {

namespace unit = pave::unit;

std::vector<SensorDrift> sensor_drifts(const study::Study& study, const problem::Evaluation& answer) {
    if (!(study.data.noise_drift > 0.0)) {
        return {};
    }
    const problem::Problem problem = study::make_noise_problem(study, study::Scope::fitted);
    std::vector<SensorDrift> drifts;
    for (const auto& [term, mean, deviation] : problem.drifts(answer)) {
        SensorDrift drift{.reading = problem.response_of(term),
                          .rate = mean * study.data.noise_drift,
                          .deviation = deviation * study.data.noise_drift};
        const auto place = [&](std::size_t i) { return study::noise_place(study.model.sensors[i]); };
        for (std::size_t i = 0; i < problem.readings(); ++i) {
            const std::size_t reading = problem.response_of(i);
            if (data::is_one_sensor(place(reading), place(drift.reading))) {
                drift.until = std::max(drift.until, study.model.sensors[reading].time.value_or(0.0));
            }
        }
        drifts.push_back(drift);
    }
    return drifts;
}

std::string drift_words(const study::Study& study, const std::vector<SensorDrift>& drifts) {
    constexpr double told = inference::two_sided_95;
    std::vector<std::string> list;
    for (const SensorDrift& drift : drifts) {
        if (std::abs(drift.rate) > told * drift.deviation) {
            const auto um = [&](double rate) { return rate * drift.until / unit::um; };
            list.push_back(fmt::format("at {} mm by {} um (+-{})",
                                       pave::figure(study.model.sensors[drift.reading].x / unit::mm),
                                       pave::figure(um(drift.rate)), pave::figure(um(told * drift.deviation))));
        }
    }
    return list.empty() ? ""
                        : fmt::format("Sensors drift, as the stated noise lets them, until their last readings: {}.",
                                      pave::join(list, "; "));
}

} // namespace explore::analysis
