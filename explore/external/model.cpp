#include "external/model.h"

#include "external/program.h"
#include "external/um_bridge.h"

#include <algorithm>
#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace explore::external {
namespace {

using Json = nlohmann::json;
using Eigen::Index;

constexpr std::string_view mark = "external ";

class ExternalFunction final : public problem::ForwardFunction {
public:
    ExternalFunction(std::shared_ptr<const Model> model, std::vector<double> nominal, std::vector<Scaling> scalings,
                     std::vector<std::size_t> which)
        : model_(std::move(model)),
          nominal_(std::move(nominal)),
          scalings_(std::move(scalings)),
          which_(std::move(which)) {}

    std::unique_ptr<Workspace> make_workspace() const override { return std::make_unique<Workspace>(); }

    pave::Outcome<problem::Prediction> evaluate(std::span<const double> parameters, bool with_jacobian,
                                                Workspace&) const override {
        std::vector<double> values = nominal_;
        std::vector<double> sizes;
        for (const Scaling& scaling : scalings_) {
            sizes.push_back(scaling.size);
        }
        for (std::size_t k = 0; k < which_.size(); ++k) {
            (is_size(k) ? sizes[which_[k] - nominal_.size()] : values[which_[k]]) = parameters[k];
        }
        auto here = model_->simulator().run(values);
        if (!here) {
            return here.failure();
        }
        const std::vector<double>& to_si = model_->to_si();
        problem::Prediction prediction;
        for (std::size_t i = 0; i < to_si.size(); ++i) {
            prediction.responses.push_back((*here)[i] * to_si[i]);
        }
        if (with_jacobian) {
            auto jacobian = derivative(values, *here);
            if (!jacobian) {
                return jacobian.failure();
            }
            prediction.jacobian =
                Eigen::Map<const Eigen::VectorXd>(to_si.data(), static_cast<Index>(to_si.size())).asDiagonal() *
                std::move(jacobian).value();
        }
        scale(prediction, sizes, with_jacobian);
        return prediction;
    }

    std::string description() const override {
        Json axes = Json::array();
        for (const problem::Axis& a : model_->space().axes) {
            axes.push_back({a.name, a.low, a.high, static_cast<int>(a.scale), a.start});
        }
        const Json all = {{"simulator", model_->simulator().description()},
                          {"axes", std::move(axes)},
                          {"switches", model_->switches()},
                          {"to_si", model_->to_si()},
                          {"nominal", nominal_},
                          {"scalings", scalings_json()},
                          {"which", which_}};
        std::string bytes(mark);
        return bytes + all.dump();
    }

private:
    bool is_size(std::size_t k) const { return which_[k] >= nominal_.size(); }

    // Scales the responses read from the model's output.
    void scale(problem::Prediction& prediction, const std::vector<double>& sizes, bool with_jacobian) const {
        for (std::size_t s = 0; s < scalings_.size(); ++s) {
            const auto own = std::find(which_.begin(), which_.end(), nominal_.size() + s);
            for (const Scaling::Row& row : scalings_[s].rows) {
                const double factor = row.constant + row.slope * sizes[s];
                double& response = prediction.responses[row.response];
                if (with_jacobian) {
                    auto derivatives = prediction.jacobian.row(static_cast<Index>(row.response));
                    derivatives *= factor;
                    if (own != which_.end()) {
                        derivatives[own - which_.begin()] += row.slope * response;
                    }
                }
                response *= factor;
            }
        }
    }

    Json scalings_json() const {
        Json list = Json::array();
        for (const Scaling& scaling : scalings_) {
            Json rows = Json::array();
            for (const Scaling::Row& row : scaling.rows) {
                rows.push_back({row.response, row.constant, row.slope});
            }
            list.push_back({std::move(rows), scaling.size});
        }
        return list;
    }

    pave::Outcome<Eigen::MatrixXd> derivative(const std::vector<double>& values,
                                              const std::vector<double>& here) const {
        const auto rows = static_cast<Index>(here.size());
        Eigen::MatrixXd result = Eigen::MatrixXd::Zero(rows, static_cast<Index>(which_.size()));
        if (model_->simulator().has_jacobian()) {
            const auto own = model_->simulator().jacobian(values);
            if (!own) {
                return own.failure();
            }
            for (std::size_t k = 0; k < which_.size(); ++k) {
                if (is_size(k)) {
                    continue;
                }
                result.col(static_cast<Index>(k)) = own->col(static_cast<Index>(which_[k]));
            }
            return result;
        }
        const Differences& differences = model_->differences();
        struct Run {
            std::size_t column = 0;
            double value = 0.0, weight = 0.0;
        };
        std::vector<Run> runs;
        for (std::size_t k = 0; k < which_.size(); ++k) {
            if (is_size(k)) {
                continue;
            }
            const problem::Axis& axis = model_->space().axes[which_[k]];
            const double unit = axis.unit(values[which_[k]]);
            const Stencil stencil = stencil_at(unit, differences, which_[k]);
            for (std::size_t s = 0; s < stencil.at.size(); ++s) {
                runs.push_back({k, axis.physical(stencil.at[s]), stencil.weights[s] / axis.d_physical(unit)});
            }
        }
        std::vector<std::optional<pave::Outcome<std::vector<double>>>> answers(runs.size());
        // Isolated: a thread that waits here begins no other evaluation.
        tbb::this_task_arena::isolate([&] {
            tbb::parallel_for(std::size_t{0}, runs.size(), [&](std::size_t r) {
                std::vector<double> moved = values;
                moved[which_[runs[r].column]] = runs[r].value;
                answers[r] = model_->simulator().run(moved);
            });
        });
        for (std::size_t r = 0; r < runs.size(); ++r) {
            const auto& answer = *answers[r];
            const std::size_t column = runs[r].column;
            if (!answer) {
                return pave::Failure{answer.status(),
                                     fmt::format("no derivative by {}, whose run at {:g} has no answer: {}",
                                                 model_->space().axes[which_[column]].name, runs[r].value,
                                                 answer.failure().reason)};
            }
            for (Index i = 0; i < rows; ++i) {
                const auto own = static_cast<std::size_t>(i);
                result(i, static_cast<Index>(column)) += runs[r].weight * ((*answer)[own] - here[own]);
            }
        }
        return result;
    }

    std::shared_ptr<const Model> model_;
    std::vector<double> nominal_;
    std::vector<Scaling> scalings_;
    std::vector<std::size_t> which_;
};

} // namespace

Model::Model(std::shared_ptr<const Simulator> simulator, problem::ParameterSpace space, std::vector<double> to_si,
             std::size_t switches)
    : simulator_(std::move(simulator)),
      space_(std::move(space)),
      to_si_(std::move(to_si)),
      switches_(switches) {}

const Differences& Model::differences() const {
    std::call_once(once_, [&] {
        std::vector<double> own;
        for (const problem::Axis& axis : space_.axes) {
            own.push_back(axis.start);
        }
        const std::vector<double> start = space_.unit(own);
        const std::ptrdiff_t moving = static_cast<std::ptrdiff_t>(start.size() - switches_);
        differences_ = estimate_differences(
            [&](std::vector<double> unit) -> std::optional<std::vector<double>> {
                unit.insert(unit.end(), start.begin() + moving, start.end());
                auto answer = simulator_->run(space_.physical(unit));
                return answer ? std::optional(std::move(answer).value()) : std::nullopt;
            },
            {start.begin(), start.begin() + moving});
        const auto widest = std::max_element(differences_.steps.begin(), differences_.steps.end());
        differences_.steps.resize(start.size(), widest != differences_.steps.end() ? *widest : 1e-3); // switches
    });
    return differences_;
}

std::string Model::derivative_words() const {
    return simulator_->has_jacobian() ? "" : differences().words();
}

std::shared_ptr<const problem::ForwardFunction> make_function(std::shared_ptr<const Model> model,
                                                              std::vector<double> nominal,
                                                              std::vector<Scaling> scalings,
                                                              std::vector<std::size_t> which) {
    return std::make_shared<ExternalFunction>(std::move(model), std::move(nominal), std::move(scalings),
                                              std::move(which));
}

bool is_description(const std::string& bytes) {
    return bytes.starts_with(mark);
}

std::shared_ptr<const problem::ForwardFunction> function_of(const std::string& description) {
    const Json all = Json::parse(description.substr(mark.size()));
    const Json of_simulator = Json::parse(all.at("simulator").get<std::string>());
    problem::ParameterSpace space;
    for (const Json& a : all.at("axes")) {
        space.axes.push_back({.name = a.at(0),
                              .low = a.at(1),
                              .high = a.at(2),
                              .scale = static_cast<problem::Scale>(a.at(3).get<int>()),
                              .start = a.at(4)});
    }
    std::vector<Scaling> scalings;
    for (const Json& s : all.at("scalings")) {
        Scaling scaling{.rows = {}, .size = s.at(1)};
        for (const Json& row : s.at(0)) {
            scaling.rows.push_back({row.at(0), row.at(1), row.at(2)});
        }
        scalings.push_back(std::move(scaling));
    }
    auto simulator = of_simulator.at("type") == "program" ? program_of(of_simulator) : client_of(of_simulator);
    return make_function(std::make_shared<Model>(std::move(simulator), std::move(space),
                                                 all.at("to_si").get<std::vector<double>>(),
                                                 all.at("switches").get<std::size_t>()),
                         all.at("nominal").get<std::vector<double>>(), std::move(scalings),
                         all.at("which").get<std::vector<std::size_t>>());
}

} // namespace explore::external
