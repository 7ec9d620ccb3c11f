#include "study/network.h"

#include <cmath>

namespace explore::study {
namespace {

class NetworkFunction final : public problem::ForwardFunction {
public:
    NetworkFunction(std::shared_ptr<const problem::ForwardFunction> network, std::vector<NetworkLevel> levels)
        : network_(std::move(network)),
          levels_(std::move(levels)) {}

    std::unique_ptr<Workspace> make_workspace() const override { return network_->make_workspace(); }

    pave::Outcome<problem::Prediction> evaluate(std::span<const double> values, bool with_jacobian,
                                                Workspace& workspace) const override {
        const auto parameters = static_cast<Eigen::Index>(values.size());
        std::vector<double> with_pressure(values.begin(), values.end());
        with_pressure.push_back(0.0);
        problem::Prediction all;
        std::vector<Eigen::RowVectorXd> rows;
        for (const NetworkLevel& level : levels_) {
            with_pressure.back() = level.pressure_kPa;
            auto outcome = network_->evaluate(with_pressure, with_jacobian, workspace);
            if (!outcome) {
                return outcome;
            }
            all.in_place_of_reduced = all.in_place_of_reduced || outcome->in_place_of_reduced;
            for (const std::size_t i : level.responses) {
                all.responses.push_back(outcome->responses[i]);
                if (with_jacobian) {
                    rows.emplace_back(outcome->jacobian.row(static_cast<Eigen::Index>(i)).head(parameters));
                }
            }
        }
        if (with_jacobian) {
            all.jacobian.resize(static_cast<Eigen::Index>(rows.size()), parameters);
            for (std::size_t i = 0; i < rows.size(); ++i) {
                all.jacobian.row(static_cast<Eigen::Index>(i)) = rows[i];
            }
        }
        return all;
    }

private:
    std::shared_ptr<const problem::ForwardFunction> network_;
    std::vector<NetworkLevel> levels_;
};

} // namespace

Study network_study(const Study& survey, const data::DeflectionBowl& layout, double low_kPa, double high_kPa) {
    data::DeflectionBowl bowl = layout;
    bowl.pressure_kPa = std::sqrt(low_kPa * high_kPa);
    Study study = station_study(survey, {}, {&bowl}, std::nullopt);
    const std::string path = study.model.loads[0].name + ".pressure_kPa";
    study.parameters.push_back(pave::pavement::find_parameter(study.model, path, {.file = study.file}));
    study.space.axes.push_back(
        {.name = path, .low = low_kPa, .high = high_kPa, .scale = problem::Scale::log, .start = bowl.pressure_kPa});
    return study;
}

problem::Problem with_network(problem::Problem station, std::shared_ptr<const problem::ForwardFunction> network,
                              std::vector<NetworkLevel> levels) {
    station.function = std::make_shared<NetworkFunction>(std::move(network), std::move(levels));
    return station;
}

} // namespace explore::study
