#include "mesh/grading.h"

#include <algorithm>
#include <cmath>

namespace pave::mesh {
namespace {

double wanted_size(double x, const std::vector<Feature>& features, const Grading& grading) {
    double size = grading.max_size;
    for (const Feature& feature : features) {
        size = std::min(size, feature.size + grading.growth * std::abs(x - feature.at));
    }
    return size;
}

} // namespace

std::vector<double> graded_lines(const std::vector<double>& breaks, const std::vector<Feature>& features,
                                 const Grading& grading) {
    constexpr int samples = 400;
    std::vector<double> lines{breaks.front()};
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
        const double a = breaks[i];
        const double step = (breaks[i + 1] - a) / samples;
        // cumulative[k] = number of cells wanted between a and a + k step (midpoint rule)
        std::vector<double> cumulative(samples + 1, 0.0);
        for (int k = 0; k < samples; ++k) {
            cumulative[k + 1] = cumulative[k] + step / wanted_size(a + (k + 0.5) * step, features, grading);
        }
        const int cells = std::max(1, static_cast<int>(std::ceil(cumulative.back() - 0.05)));
        int k = 0;
        for (int c = 1; c < cells; ++c) {
            const double target = cumulative.back() * c / cells;
            while (cumulative[k + 1] < target) {
                ++k;
            }
            const double part = (target - cumulative[k]) / (cumulative[k + 1] - cumulative[k]);
            lines.push_back(a + (k + part) * step);
        }
        lines.push_back(breaks[i + 1]);
    }
    return lines;
}

} // namespace pave::mesh
