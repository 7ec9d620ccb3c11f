#include "reduced/nonnegative.h"

#include <Eigen/QR>
#include <vector>

namespace pave::reduced {

Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double tolerance,
                                          int most) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(a.cols());
    std::vector<Eigen::Index> passive; // the columns that may be positive
    std::vector<char> is_passive(static_cast<std::size_t>(a.cols()), 0);
    Eigen::VectorXd left = b;
    while (left.norm() > tolerance * b.norm() && static_cast<int>(passive.size()) < most) {
        // The column that the rest wants most.
        const Eigen::VectorXd wanted = a.transpose() * left;
        Eigen::Index best = -1;
        for (Eigen::Index j = 0; j < a.cols(); ++j) {
            if (is_passive[static_cast<std::size_t>(j)] == 0 && wanted[j] > 0.0 &&
                (best < 0 || wanted[j] > wanted[best])) {
                best = j;
            }
        }
        if (best < 0) {
            break;
        }
        passive.push_back(best);
        is_passive[static_cast<std::size_t>(best)] = 1;
        for (;;) {
            const Eigen::VectorXd free = Eigen::MatrixXd(a(Eigen::all, passive)).householderQr().solve(b);
            if (free.minCoeff() > 0.0) {
                x(passive) = free;
                break;
            }
            // Towards the free solution until the first entry is zero, which leaves the set.
            double step = 1.0;
            for (Eigen::Index i = 0; i < free.size(); ++i) {
                const double now = x[passive[static_cast<std::size_t>(i)]];
                if (free[i] <= 0.0) {
                    step = std::min(step, now / (now - free[i]));
                }
            }
            std::vector<Eigen::Index> stay;
            for (Eigen::Index i = 0; i < free.size(); ++i) {
                const Eigen::Index j = passive[static_cast<std::size_t>(i)];
                x[j] += step * (free[i] - x[j]);
                if (x[j] > 1e-14 * x.maxCoeff() && (free[i] > 0.0 || step < 1.0) && x[j] > 0.0) {
                    stay.push_back(j);
                } else {
                    x[j] = 0.0;
                    is_passive[static_cast<std::size_t>(j)] = 0;
                }
            }
            if (stay.size() == passive.size() || stay.empty()) {
                passive = std::move(stay);
                break;
            }
            passive = std::move(stay);
        }
        left = b - a(Eigen::all, passive) * x(passive);
    }
    return x;
}

} // namespace pave::reduced
