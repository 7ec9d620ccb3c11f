#include "mesh/grading.h"

#include <algorithm>
#include <cmath>

namespace pave::mesh {
namespace {

// The smallest size wanted from `from` to `to`.
double wanted_size(double from, double to, const std::vector<Feature>& features, const Grading& grading) {
    double size = grading.max_size;
    for (const Feature& feature : features) {
        const double distance = std::max({from - feature.at, feature.at - to, 0.0});
        size = std::min(size, feature.size + grading.growth * distance);
    }
    return size;
}

} // namespace

std::vector<double> graded_lines(const std::vector<double>& breaks, const std::vector<Feature>& features,
                                 const Grading& grading) {
    constexpr int samples = 400;
    struct Sample {
        double end;
        double cells; // wanted up to it
    };
    std::vector<double> lines{breaks.front()};
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
        const double a = breaks[i];
        const double step = (breaks[i + 1] - a) / samples;
        // Midpoint rule on equal steps, each in parts no longer than half the size wanted there: however far apart the
        // breaks are, no feature is passed over.
        std::vector<Sample> cumulative{{a, 0.0}};
        for (int k = 0; k < samples; ++k) {
            const double from = a + k * step;
            const double parts =
                std::max(1.0, std::ceil(2.0 * step / wanted_size(from, from + step, features, grading)));
            for (int p = 0; p < parts; ++p) {
                const double middle = from + (p + 0.5) * step / parts;
                cumulative.push_back(
                    {from + (p + 1) * step / parts,
                     cumulative.back().cells + step / parts / wanted_size(middle, middle, features, grading)});
            }
        }
        const double wanted = cumulative.back().cells;
        const int cells = std::max(1, static_cast<int>(std::ceil(wanted - 0.05)));
        std::size_t k = 0;
        for (int c = 1; c < cells; ++c) {
            const double target = wanted * c / cells;
            while (cumulative[k + 1].cells < target) {
                ++k;
            }
            const double part = (target - cumulative[k].cells) / (cumulative[k + 1].cells - cumulative[k].cells);
            lines.push_back(cumulative[k].end + part * (cumulative[k + 1].end - cumulative[k].end));
        }
        lines.push_back(breaks[i + 1]);
    }
    return lines;
}

std::vector<double> without_slivers(const std::vector<double>& breaks, const std::vector<Feature>& features,
                                    const Grading& grading) {
    constexpr double sliver = 0.1; // of a cell
    const auto is_sliver = [&](double from, double to) {
        return to - from < sliver * wanted_size(from, to, features, grading);
    };
    std::vector<double> kept{breaks.front()};
    for (std::size_t i = 1; i + 1 < breaks.size(); ++i) {
        if (!is_sliver(kept.back(), breaks[i]) && !is_sliver(breaks[i], breaks.back())) {
            kept.push_back(breaks[i]);
        }
    }
    kept.push_back(breaks.back());
    return kept;
}

} // namespace pave::mesh
