#include "landscape/sensitivity.h"

#include "base/random.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace explore::landscape {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr Eigen::Index resamples = 1000;

// One row of the design a row: y(A), y(B), y(AB_i).
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct Shares {
    double mean = 0.0;
    double variance = 0.0;
    Eigen::ArrayXd first, total;
};

// The two formulas over as many rows as there are: row_of(0), row_of(1), ..., any of which may come more than once.
template <class RowOf>
Shares shares_of(const Rows& y, const RowOf& row_of) {
    const Eigen::Index d = y.cols() - 2;
    const auto n = static_cast<double>(y.rows());
    double sum = 0.0;
    double squares = 0.0;
    Eigen::ArrayXd product = Eigen::ArrayXd::Zero(d);
    Eigen::ArrayXd change = Eigen::ArrayXd::Zero(d);
    Eigen::ArrayXd square = Eigen::ArrayXd::Zero(d);
    for (Eigen::Index j = 0; j < y.rows(); ++j) {
        const Eigen::Index r = row_of(j);
        const double a = y(r, 0);
        const double b = y(r, 1);
        sum += a + b;
        squares += a * a + b * b;
        for (Eigen::Index i = 0; i < d; ++i) {
            const double step = y(r, 2 + i) - a;
            product[i] += b * step;
            change[i] += step;
            square[i] += step * step;
        }
    }
    Shares s;
    s.mean = sum / (2.0 * n);
    s.variance = squares / (2.0 * n) - s.mean * s.mean;
    s.first = (product - s.mean * change) / (n * s.variance);
    s.total = square / (2.0 * n * s.variance);
    return s;
}

// The 2.5th and 97.5th percentile of what is a number.
Estimate with_interval(double value, std::vector<double> samples) {
    std::erase_if(samples, [](double v) { return !std::isfinite(v); });
    if (!std::isfinite(value) || samples.empty()) {
        return {nan, nan, nan};
    }
    std::sort(samples.begin(), samples.end());
    const std::size_t tail = samples.size() / 40;
    return {value, samples[tail], samples[samples.size() - 1 - tail]};
}

SobolIndices indices_of(Rows y, const pave::RandomStream& random) {
    // Away from a large mean the sums lose no digits.
    const double shift = y(0, 0);
    y.array() -= shift;
    const Shares whole = shares_of(y, [](Eigen::Index j) { return j; });
    std::vector<Shares> replicates;
    for (Eigen::Index k = 0; k < resamples; ++k) {
        replicates.push_back(shares_of(y, [&](Eigen::Index j) {
            const double u = random.uniform(static_cast<std::uint64_t>(k * y.rows() + j));
            return std::min(y.rows() - 1, static_cast<Eigen::Index>(u * static_cast<double>(y.rows())));
        }));
    }
    SobolIndices indices;
    indices.mean = shift + whole.mean;
    indices.variance = whole.variance;
    for (Eigen::Index i = 0; i < y.cols() - 2; ++i) {
        std::vector<double> first;
        std::vector<double> total;
        for (const Shares& s : replicates) {
            first.push_back(s.first[i]);
            total.push_back(s.total[i]);
        }
        indices.first.push_back(with_interval(whole.first[i], std::move(first)));
        indices.total.push_back(with_interval(whole.total[i], std::move(total)));
    }
    std::vector<double> interactions;
    std::transform(replicates.begin(), replicates.end(), std::back_inserter(interactions),
                   [](const Shares& s) { return 1.0 - s.first.sum(); });
    indices.interactions = with_interval(1.0 - whole.first.sum(), std::move(interactions));
    return indices;
}

} // namespace

Eigen::MatrixXd elasticities(const problem::Evaluation& evaluation) {
    Eigen::MatrixXd e = evaluation.jacobian;
    for (Eigen::Index i = 0; i < e.rows(); ++i) {
        for (Eigen::Index k = 0; k < e.cols(); ++k) {
            const double response = evaluation.responses[static_cast<std::size_t>(i)];
            const double parameter = evaluation.parameters[static_cast<std::size_t>(k)];
            e(i, k) = response == 0.0 || parameter == 0.0 ? nan : e(i, k) * parameter / response;
        }
    }
    return e;
}

GlobalSensitivity sobol_indices(const std::vector<problem::Evaluation>& evaluations, std::size_t dimension,
                                const std::vector<std::size_t>& responses, std::uint64_t seed) {
    const std::size_t width = dimension + 2;
    GlobalSensitivity result;
    result.rows = evaluations.size() / width;
    std::vector<std::size_t> complete; // the first evaluation of each complete row
    for (std::size_t j = 0; j < result.rows; ++j) {
        const auto row = evaluations.begin() + static_cast<std::ptrdiff_t>(j * width);
        if (std::all_of(row, row + static_cast<std::ptrdiff_t>(width), [](const auto& e) { return e.converged(); })) {
            complete.push_back(j * width);
        }
    }
    result.complete = complete.size();
    if (complete.size() < 2) {
        return result;
    }
    const pave::RandomStream random(seed, 2); // the same resamples for every response
    for (const std::size_t response : responses) {
        Rows y(static_cast<Eigen::Index>(complete.size()), static_cast<Eigen::Index>(width));
        for (std::size_t j = 0; j < complete.size(); ++j) {
            for (std::size_t c = 0; c < width; ++c) {
                y(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(c)) =
                    evaluations[complete[j] + c].responses[response];
            }
        }
        result.responses.push_back(indices_of(std::move(y), random));
    }
    return result;
}

} // namespace explore::landscape
