#include "analysis/common/candidate_readings.h"

#include "study/candidates.h"

#include <algorithm>
#include <cmath>
#include <ctime>

namespace explore::analysis {

CandidateReadings::CandidateReadings(const study::Study& study)
    : list_(study::candidates(study)),
      problem_(study::make_prediction_problem(list_)),
      workspace_(problem_.function->make_workspace()) {}

problem::Evaluation CandidateReadings::at(const std::vector<double>& unit, bool with_jacobian) {
    const std::clock_t begin = std::clock();
    auto evaluation = problem_.evaluate(unit, with_jacobian, *workspace_);
    forward_cpu_seconds_ += static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    return evaluation;
}

std::vector<data::Reading> CandidateReadings::readings(const problem::Evaluation& there) const {
    std::vector<data::Reading> readings = list_.readings;
    for (std::size_t i = 0; i < readings.size(); ++i) {
        readings[i].value = readings[i].in_unit(there.responses[i]);
        readings[i].noise.absolute = study::candidate_noise(list_.model.sensors[i].quantity, there.responses[i]);
    }
    return readings;
}

Eigen::MatrixXd CandidateReadings::rows(const problem::Evaluation& there, const std::vector<double>& unit,
                                        const std::vector<data::Reading>& readings) const {
    Eigen::MatrixXd rows(static_cast<Eigen::Index>(readings.size()), static_cast<Eigen::Index>(unit.size()));
    for (std::size_t i = 0; i < readings.size(); ++i) {
        for (std::size_t k = 0; k < unit.size(); ++k) {
            const auto row = static_cast<Eigen::Index>(i);
            const auto column = static_cast<Eigen::Index>(k);
            rows(row, column) =
                there.jacobian(row, column) * problem_.space.axes[k].d_physical(unit[k]) / readings[i].noise.absolute;
        }
    }
    return rows;
}

bool is_at_hand(const study::Study& study, const data::Reading& reading) {
    const auto found = std::find_if(std::begin(pave::pavement::quantities), std::end(pave::pavement::quantities),
                                    [&](const auto& about) { return about.name == reading.quantity; });
    return found != std::end(pave::pavement::quantities) && study.is_at_hand(found->quantity);
}

std::vector<TellingReading> telling_readings(const study::Study& study, const std::vector<double>& unit,
                                             const Eigen::MatrixXd& covariance, std::size_t others) {
    if (study.has_own_model) {
        return {};
    }
    CandidateReadings candidates(study);
    const auto there = candidates.at(unit, true);
    std::vector<TellingReading> telling;
    if (!there.converged()) {
        return telling;
    }
    const auto readings = candidates.readings(there);
    const Eigen::MatrixXd rows = candidates.rows(there, unit, readings);
    // Of the others, where those of interest are known.
    const auto n = static_cast<Eigen::Index>(others);
    const Eigen::Index asked = covariance.rows() - n;
    const Eigen::MatrixXd across = covariance.topRightCorner(n, asked);
    const Eigen::MatrixXd given = covariance.topLeftCorner(n, n) -
                                  across * covariance.bottomRightCorner(asked, asked).llt().solve(across.transpose());
    for (std::size_t i = 0; i < readings.size(); ++i) {
        const Eigen::RowVectorXd row = rows.row(static_cast<Eigen::Index>(i));
        const Eigen::RowVectorXd own = row.head(n);
        const double before = 1.0 + row.dot(covariance * row.transpose());
        const double after = 1.0 + std::max(0.0, own.dot(given * own.transpose()));
        telling.push_back({readings[i], 0.5 * std::log2(std::max(1.0, before / after))});
    }
    std::stable_sort(telling.begin(), telling.end(), [](const auto& a, const auto& b) { return a.bits > b.bits; });
    std::stable_partition(telling.begin(), telling.end(),
                          [&](const auto& own) { return is_at_hand(study, own.reading); });
    return telling;
}

} // namespace explore::analysis
