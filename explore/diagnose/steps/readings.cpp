// Several wrong readings, found one after the other.
#include "diagnose/steps/investigation.h"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>

namespace explore::diagnose {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr std::size_t most_wrong = 5;

// Beyond what is followed already.
VectorXd beyond(const MatrixXd& base, const VectorXd& change) {
    return change - base * (base.transpose() * change);
}

// The two changes that together explain most of what is left, if noise explains the rest; none: it does not.
std::vector<std::size_t> pair_that_explains(const std::vector<VectorXd>& changes, const VectorXd& left, double dof) {
    constexpr double by_noise = 0.05;
    if (dof <= 2.0) {
        return {};
    }
    double least = gsl_cdf_chisq_Qinv(by_noise, dof - 2.0);
    std::vector<std::size_t> pair;
    for (std::size_t i = 0; i < changes.size(); ++i) {
        for (std::size_t j = i + 1; j < changes.size(); ++j) {
            MatrixXd both(left.size(), 2);
            both << changes[i], changes[j];
            const Eigen::ColPivHouseholderQR<MatrixXd> qr(both);
            if (qr.rank() < 2) {
                continue;
            }
            const double rest = (left - both * qr.solve(left)).squaredNorm();
            if (rest < least) {
                least = rest;
                pair = {i, j};
            }
        }
    }
    return pair;
}

// To first order at a model: of the readings that are not among its members, the one that stands out farthest while the
// others scatter as they do, then the next beside it. Their candidates.
std::vector<std::size_t> wrong_readings_beside(const problem::Problem& problem, const inference::Nuisance& nuisance,
                                               const VectorXd& residuals, const std::vector<Candidate>& candidates,
                                               const Members& members, std::size_t most) {
    std::vector<std::size_t> open;
    std::vector<VectorXd> changes;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
        if (candidates[c].reading && std::find(members.begin(), members.end(), c) == members.end()) {
            open.push_back(c);
            changes.push_back(nuisance.beyond(problem.change_by(*candidates[c].reading)));
        }
    }
    const auto of_readings = static_cast<double>(open.size());
    MatrixXd followed(residuals.size(), 0);
    VectorXd left = nuisance.beyond(residuals);
    double dof = static_cast<double>(residuals.size() - nuisance.rank()) - static_cast<double>(problem.censored());
    std::vector<std::size_t> found;
    while (found.size() < most && dof > 2.0) {
        double largest = 0.0;
        std::size_t leading = open.size();
        VectorXd along;
        for (std::size_t i = 0; i < open.size(); ++i) {
            VectorXd direction = beyond(followed, changes[i]);
            const double length = direction.norm();
            constexpr double seen = 0.3; // of a standard deviation of its error, the parameters do not follow
            if (length < seen || std::find(found.begin(), found.end(), open[i]) != found.end()) {
                continue;
            }
            direction /= length;
            if (const double score = std::abs(direction.dot(left)); score > largest) {
                largest = score;
                leading = i;
                along = std::move(direction);
            }
        }
        if (leading == open.size()) {
            break;
        }
        // By what the others leave: noise that is larger than stated makes no reading wrong.
        const double rest = std::max(1.0, (left.squaredNorm() - largest * largest) / (dof - 1.0));
        const double p = 2.0 * of_readings * gsl_cdf_tdist_Q(largest / std::sqrt(rest), dof - 1.0);
        // Another wrong reading may hide this one by what it adds to the rest; what does not stand out the evidence
        // says.
        constexpr double hardly = 0.2;
        if (p > hardly) {
            break;
        }
        found.push_back(open[leading]);
        followed.conservativeResize(Eigen::NoChange, followed.cols() + 1);
        followed.rightCols(1) = along;
        left -= along * along.dot(left);
        dof -= 1.0;
    }
    // Two may hide each other, and stand out only together.
    if (members.empty() && found.size() < 2 && most >= 2) {
        const auto pair = pair_that_explains(changes, nuisance.beyond(residuals),
                                             static_cast<double>(residuals.size() - nuisance.rank()) -
                                                 static_cast<double>(problem.censored()));
        if (!pair.empty()) {
            found = {open[pair[0]], open[pair[1]]};
        }
    }
    return found;
}

} // namespace

// Those that stand out, together, and again from where the fit ends. False: interrupted.
bool Investigation::fit_wrong_readings() {
    wrong_readings_.clear();
    Model from = d_.baseline.model;
    constexpr int rounds = 2;
    for (int round = 0; round < rounds && from.members.size() < most_wrong; ++round) {
        const auto problem = bench_.problem(from.members);
        const VectorXd residuals = from.residuals / std::sqrt(d_.variance);
        // One in six, or two of nine.
        const std::size_t in_all = std::min(most_wrong, std::max<std::size_t>(rows() / 6, rows() < 9 ? 0 : 2));
        const std::size_t most = in_all - std::min(from.members.size(), in_all);
        const auto more =
            wrong_readings_beside(*problem, nuisance_of(from), residuals, task_.candidates, from.members, most);
        if (more.empty() || from.members.size() + more.size() < 2) {
            break;
        }
        // Each number of them is a hypothesis of its own: the first two, three, ...
        Members members = from.members;
        std::optional<Model> found;
        for (const std::size_t c : more) {
            const std::size_t at = size_index(bench_, with_member(members, c), c);
            std::vector<double> start = with_size((found ? *found : from).unit, at, task_.candidates[c].null);
            members = with_member(members, c);
            if (members.size() < 2) {
                from.unit = start;
                continue;
            }
            const int number = readings_number + 10 * round + static_cast<int>(members.size());
            found = fit_from(members, number, start);
            if (run::interrupted()) {
                return false;
            }
            if (!found) {
                break;
            }
            wrong_readings_.push_back(judged(*found));
        }
        if (!found) {
            break;
        }
        from = *found;
    }
    std::stable_sort(wrong_readings_.begin(), wrong_readings_.end(),
                     [](const Judged& a, const Judged& b) { return a.aicc < b.aicc; });
    return true;
}

} // namespace explore::diagnose
