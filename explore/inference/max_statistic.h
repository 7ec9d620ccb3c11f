// How large the largest of many statistics gets by chance.
#pragma once

#include "inference/nuisance.h"

#include <cstdint>
#include <functional>

namespace explore::inference {

// How large the largest of several statistics gets when there is nothing but noise.
class MaxStatistic {
public:
    // directions: unit vectors, one column a statistic: minus their product with the residuals. Only the sign of
    // `sense` counts, where it is not 0. estimated: the noise is that of the residuals, beyond `nuisance`.
    // rows_of: residuals in standard deviations by standard normal deviates; without: the deviates.
    MaxStatistic(const Eigen::MatrixXd& directions, const std::vector<int>& sense, const Nuisance& nuisance,
                 bool estimated, std::uint64_t seed,
                 const std::function<Eigen::VectorXd(Eigen::VectorXd)>& rows_of = {});

    // The chance that the largest statistic of the family reaches this under noise alone. Simulated with 10,000 draws;
    // below their reach by the bound of Bonferroni, which is close there.
    double p_value(double statistic) const;
    // The limit that the largest statistic exceeds with this probability.
    double threshold(double p) const;

private:
    std::vector<double> largest_; // descending
    std::vector<int> sense_;
};

} // namespace explore::inference
