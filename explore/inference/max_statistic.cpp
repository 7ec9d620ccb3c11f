#include "inference/max_statistic.h"

#include "base/random.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>

namespace explore::inference {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MaxStatistic::MaxStatistic(const MatrixXd& directions, const std::vector<int>& sense, const Nuisance& nuisance,
                           bool estimated, std::uint64_t seed, const std::function<VectorXd(VectorXd)>& rows_of)
    : sense_(sense) {
    constexpr int draws = 10'000;
    const Index n = directions.rows();
    const pave::RandomStream random(seed, 6);
    VectorXd deviates(n);
    for (int draw = 0; draw < draws; ++draw) {
        for (Index i = 0; i < n; ++i) {
            deviates[i] = random.normal(static_cast<std::uint64_t>(draw) * static_cast<std::uint64_t>(n) +
                                        static_cast<std::uint64_t>(i));
        }
        const VectorXd noise = rows_of ? rows_of(deviates) : deviates;
        const double scale = estimated ? nuisance.beyond(noise).norm() /
                                             std::sqrt(std::max(1.0, static_cast<double>(n - nuisance.rank())))
                                       : 1.0;
        const VectorXd statistics = -directions.transpose() * noise / scale;
        double largest = 0.0;
        for (Index j = 0; j < statistics.size(); ++j) {
            const int s = sense[static_cast<std::size_t>(j)];
            largest = std::max(largest, s == 0 ? std::abs(statistics[j]) : s * statistics[j]);
        }
        largest_.push_back(largest);
    }
    std::sort(largest_.begin(), largest_.end(), std::greater<>());
}

double MaxStatistic::p_value(double statistic) const {
    const auto above = std::lower_bound(largest_.begin(), largest_.end(), statistic, std::greater_equal<>());
    const auto count = static_cast<double>(above - largest_.begin());
    constexpr double reach = 20.0; // draws
    if (count >= reach) {
        return count / static_cast<double>(largest_.size());
    }
    double sum = 0.0;
    for (const int s : sense_) {
        sum += (s == 0 ? 2.0 : 1.0) * gsl_cdf_ugaussian_Q(statistic);
    }
    return std::min(sum, reach / static_cast<double>(largest_.size()));
}

double MaxStatistic::threshold(double p) const {
    return largest_[static_cast<std::size_t>(p * static_cast<double>(largest_.size()))];
}

} // namespace explore::inference
