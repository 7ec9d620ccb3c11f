#include "analysis/studies/twin.h"

#include "analysis/common/load_steps.h"
#include "base/error.h"
#include "base/random.h"
#include "problem/student.h"
#include "study/problems.h"
#include "study/readings.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace explore::analysis {
namespace {

// Of every measured reading, over its value.
std::vector<double> relative_errors(const study::Study& study, const pave::RandomStream& random, double noise) {
    const auto n = static_cast<Eigen::Index>(study.measured().size());
    Eigen::VectorXd own(n);
    for (Eigen::Index i = 0; i < n; ++i) {
        const auto k = static_cast<std::uint64_t>(i);
        own[i] = study.data.noise_degrees > 0.0
                     ? problem::student_draw(random.uniform(2 * k), random.uniform(2 * k + 1), study.data.noise_degrees)
                     : random.normal(k);
    }
    const auto place = [&](Eigen::Index i) {
        return study::noise_place(study.model.sensors[static_cast<std::size_t>(i)]);
    };
    if (study.data.correlates_readings()) {
        Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(n, n);
        for (Eigen::Index i = 0; i < n; ++i) {
            for (Eigen::Index j = 0; j < i; ++j) {
                correlation(i, j) = correlation(j, i) = data::own_correlation(
                    place(i), place(j), study.data.noise_correlation_length, study.data.noise_correlation_time);
            }
        }
        own = correlation.llt().matrixL() * own;
    }
    std::vector<double> errors;
    for (Eigen::Index i = 0; i < n; ++i) {
        double error = noise * own[i];
        if (noise > 0.0 && study.data.noise_common_relative > 0.0) { // one draw a load
            const auto number = static_cast<std::uint64_t>(n + place(i).load);
            error += study.data.noise_common_relative * random.normal(number);
        }
        errors.push_back(error);
    }
    return errors;
}

// The drift of each sensor [SI], one draw a sensor.
std::vector<double> drifts(const study::Study& study, const pave::RandomStream& random) {
    const std::size_t n = study.measured().size();
    std::vector<double> drifts(n, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
        const auto place = [&](std::size_t k) { return study::noise_place(study.model.sensors[k]); };
        std::size_t first = 0; // reading of the sensor
        while (!data::is_one_sensor(place(first), place(i))) {
            ++first;
        }
        drifts[i] = study.readings[i].noise.drift * random.normal(first);
    }
    return drifts;
}

} // namespace

TwinResult twin(study::Study study, const TwinOptions& options) {
    for (const auto& [name, size] : options.effects) {
        study = study::with_effect(std::move(study), name, size, {.key = "--effect"});
    }
    study = with_enough_load_steps(std::move(study), options.noise);
    const auto measured = study.measured();
    if (measured.empty()) {
        throw pave::Error({.file = study.file, .key = "data"}, "a twin needs a layout of sensors", {},
                          "[data] files = [...]: their values are replaced, their places kept");
    }
    TwinResult result{.study = study, .options = options};
    const auto model = study::function_of(study, {}, {});
    const auto outcome = model->evaluate({}, false, *model->make_workspace());
    result.status = outcome.status();
    if (!outcome) {
        result.reason = outcome.failure().reason;
        return result;
    }
    const pave::RandomStream random(options.seed, 1);
    const auto errors = relative_errors(study, random, options.noise);
    const auto drifted = drifts(study, pave::RandomStream(options.seed, 2));
    for (std::size_t i = 0; i < measured.size(); ++i) {
        data::Reading reading = measured[i];
        const double exact = reading.in_unit(outcome->responses[i]);
        reading.value = exact * (1.0 + errors[i]) + (options.noise > 0.0 ? reading.in_unit(drifted[i]) : 0.0);
        reading.censored = data::Censored::no;
        reading.sigma = options.noise > 0.0 ? std::optional(options.noise * std::abs(exact)) : std::nullopt;
        result.exact.push_back(exact);
        result.readings.push_back(std::move(reading));
    }
    return result;
}

} // namespace explore::analysis
