#include "analysis/candidate_readings.h"

#include "study/candidates.h"

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

} // namespace explore::analysis
