#include "analysis/sample/predictive.h"

#include "problem/noise_scale.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <limits>
#include <numeric>

namespace explore::analysis {
namespace {

// A reading by one set: value and standard deviation (of Student's t: scale).
struct Component {
    double value = 0.0, deviation = 0.0, weight = 0.0;
};

class Mixture {
public:
    Mixture(std::vector<Component> components, double degrees)
        : components_(std::move(components)),
          degrees_(degrees) {}

    double below(double y) const {
        double share = 0.0;
        for (const Component& c : components_) {
            const double z = (y - c.value) / c.deviation;
            share += c.weight * (degrees_ > 0.0 ? gsl_cdf_tdist_P(z, degrees_) : gsl_cdf_ugaussian_P(z));
        }
        return share;
    }
    double quantile(double share) const {
        const double far = degrees_ > 0.0 ? gsl_cdf_tdist_Pinv(share, degrees_) : gsl_cdf_ugaussian_Pinv(share);
        double low = std::numeric_limits<double>::infinity();
        double high = -low;
        for (const Component& c : components_) { // it lies between those of the components
            low = std::min(low, c.value + far * c.deviation);
            high = std::max(high, c.value + far * c.deviation);
        }
        constexpr int halvings = 50;
        for (int i = 0; i < halvings; ++i) {
            const double middle = 0.5 * (low + high);
            (below(middle) < share ? low : high) = middle;
        }
        return 0.5 * (low + high);
    }

private:
    std::vector<Component> components_;
    double degrees_; // of Student's t; 0: normal
};

} // namespace

std::vector<PredictedReading> predicted(const problem::Problem& problem, const study::Study& study,
                                        const Predictions& predictions) {
    const std::size_t sets = predictions.responses.size();
    const double all = std::accumulate(predictions.weight.begin(), predictions.weight.end(), 0.0);
    const bool sought = problem.noise_scale_is_sought();
    std::vector<double> size(sets, 1.0);
    for (std::size_t s = 0; s < sets && sought; ++s) {
        problem::Evaluation e;
        e.status = pave::Status::converged;
        e.responses = predictions.responses[s];
        size[s] = problem.noise_scale(e);
    }
    const double degrees = sought ? problem::degrees_of_sought_scale(problem.readings()) : problem.noise_degrees();
    std::vector<PredictedReading> readings;
    for (std::size_t i = 0; i < problem.readings(); ++i) {
        const std::size_t row = problem.response_of(i);
        const data::Noise& noise = study.readings[row].noise;
        std::vector<Component> components(sets);
        for (std::size_t s = 0; s < sets; ++s) {
            const double value = predictions.responses[s][row];
            components[s] = {value, size[s] * noise.deviation(value), predictions.weight[s] / all};
        }
        const Mixture mixture(std::move(components), degrees);
        readings.push_back({.row = row,
                            .low = mixture.quantile(0.025),
                            .median = mixture.quantile(0.5),
                            .high = mixture.quantile(0.975),
                            .below = mixture.below(problem.measured(i))});
    }
    return readings;
}

} // namespace explore::analysis
