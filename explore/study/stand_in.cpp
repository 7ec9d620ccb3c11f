#include "study/stand_in.h"

#include "study/problems.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace explore::study {
namespace {

using Eigen::Index;

// Of each response: the measured value [SI] and what is allowed near it, and 0 where nothing is required.
struct AllowedError {
    double measured = 0.0;
    double least = 0.0;  // whatever the residual
    double growth = 0.0; // a share of the residual
};

std::vector<AllowedError> allowed_errors(const Study& study, const Eigen::VectorXd& ranges, double limit) {
    std::vector<AllowedError> list(study.readings.size());
    constexpr double deviations = 10.0;
    for (const Group& group : study.groups) {
        if (group.held_out) {
            continue;
        }
        for (const std::size_t row : group.rows) {
            const data::Reading& reading = study.readings[row];
            const double measured = reading.measured();
            const bool stated = study.noise == NoiseSource::stated;
            list[row] = {.measured = measured,
                         .least =
                             limit * (stated ? deviations * reading.noise.deviation(measured) : std::abs(measured)),
                         .growth = limit};
        }
    }
    if (!study.constraints.empty()) {
        for (const std::size_t output : study.outputs()) {
            list[output].least = limit * ranges[static_cast<Index>(output)];
        }
    }
    return list;
}

double share_of_allowed(const std::vector<AllowedError>& allowed, double factor,
                        const inference::Kriging::Answer& answer) {
    double largest = 0.0;
    for (std::size_t i = 0; i < allowed.size(); ++i) {
        const auto own = static_cast<Index>(i);
        const double most =
            std::max(allowed[i].least, allowed[i].growth * std::abs(answer.values[own] - allowed[i].measured));
        if (most > 0.0) {
            largest = std::max(largest, factor * answer.deviations[own] / most);
        }
    }
    return largest;
}

class StandInFunction final : public problem::ForwardFunction {
public:
    StandInFunction(std::shared_ptr<const problem::ForwardFunction> full, const Study& study,
                    std::shared_ptr<const StandIn> stand_in, double limit)
        : full_(std::move(full)),
          space_(study.space),
          stand_in_(std::move(stand_in)),
          allowed_(allowed_errors(study, stand_in_->between.ranges(), limit)) {}

    std::unique_ptr<Workspace> make_workspace() const override { return full_->make_workspace(); }

    pave::Outcome<problem::Prediction> evaluate(std::span<const double> values, bool with_jacobian,
                                                Workspace& workspace) const override {
        const std::vector<double> unit = space_.unit(values);
        problem::Prediction prediction;
        if (!near_hole(unit)) {
            const inference::Kriging::Answer answer = stand_in_->between.at(unit, with_jacobian);
            if (answer.values.allFinite() && share_of_allowed(allowed_, stand_in_->factor, answer) <= 1.0) {
                prediction.responses.assign(answer.values.begin(), answer.values.end());
                prediction.jacobian = answer.slopes;
                for (Index k = 0; k < prediction.jacobian.cols(); ++k) {
                    const auto own = static_cast<std::size_t>(k);
                    prediction.jacobian.col(k) /= space_.axes[own].d_physical(unit[own]);
                }
                return prediction;
            }
        }
        auto answer = full_->evaluate(values, with_jacobian, workspace);
        if (!answer) {
            return answer;
        }
        prediction = std::move(answer).value();
        prediction.in_place_of_reduced = true;
        return prediction;
    }

private:
    bool near_hole(std::span<const double> unit) const {
        const inference::Kriging& between = stand_in_->between;
        double hole = std::numeric_limits<double>::infinity();
        for (const auto& point : stand_in_->holes) {
            hole = std::min(hole, between.squared_distance(unit, point));
        }
        return std::isfinite(hole) &&
               std::none_of(between.known().begin(), between.known().end(), [&](const inference::KnownPoint& known) {
                   return between.squared_distance(unit, known.unit) < hole;
               });
    }

    std::shared_ptr<const problem::ForwardFunction> full_;
    problem::ParameterSpace space_;
    std::shared_ptr<const StandIn> stand_in_;
    std::vector<AllowedError> allowed_;
};

} // namespace

inference::KnownPoint known_point(const Study& study, const problem::Evaluation& evaluation) {
    inference::KnownPoint point{.unit = study.space.unit(evaluation.parameters),
                                .values = Eigen::Map<const Eigen::VectorXd>(
                                    evaluation.responses.data(), static_cast<Index>(evaluation.responses.size()))};
    point.slopes = evaluation.jacobian;
    for (Index k = 0; k < point.slopes.cols(); ++k) {
        const auto own = static_cast<std::size_t>(k);
        point.slopes.col(k) *= study.space.axes[own].d_physical(point.unit[own]);
    }
    return point;
}

double error_of_allowed(const Study& study, const StandIn& stand_in, double limit,
                        const inference::Kriging::Answer& answer) {
    return share_of_allowed(allowed_errors(study, stand_in.between.ranges(), limit), stand_in.factor, answer);
}

problem::Problem with_stand_in(problem::Problem fitted, const Study& study, std::shared_ptr<const StandIn> stand_in,
                               double limit) {
    fitted.function = std::make_shared<StandInFunction>(fitted.function, study, std::move(stand_in), limit);
    return fitted;
}

} // namespace explore::study
