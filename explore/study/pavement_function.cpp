#include "study/pavement_function.h"

#include "external/model.h"
#include "material/catalog.h"
#include "pavement/effects/catalog.h"
#include "pavement/tie.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace explore::study {
namespace {

using namespace pave::pavement;
using Json = nlohmann::json;

// A case as nested arrays, in the order of the members. members() binds every member of a struct by name, so that a new
// one does not compile until it travels too.
template <class Archive, class T>
void members(Archive& archive, T& value);

class Packer {
public:
    template <class... T>
    void operator()(const T&... values) {
        (packed.push_back(pack(values)), ...);
    }
    template <class T>
    static Json pack(const T& value) {
        Packer inner;
        members(inner, value);
        return std::move(inner.packed);
    }
    static Json pack(const std::string& value) { return value; }
    static Json pack(double value) { return value; }
    static Json pack(int value) { return value; }
    static Json pack(bool value) { return value; }
    template <class E>
    requires std::is_enum_v<E>
    static Json pack(const E& value) { return static_cast<int>(value); }
    static Json pack(const pave::material::Law* const& law) { return std::string(law->name()); }
    static Json pack(const Effect* const& effect) { return std::string(effect->name); }
    static Json pack(const pave::fe::Field&) {
        throw std::logic_error("fields come from effects, which travel themselves");
    }
    static Json pack(const Tie& tie) { return Json::array({tie.path, tie.expression.text()}); }
    template <class T>
    static Json pack(const std::optional<T>& value) {
        return value ? Json(Json::array({pack(*value)})) : Json(Json::array());
    }
    template <class T>
    static Json pack(const std::vector<T>& values) {
        Json array = Json::array();
        for (const T& value : values) {
            array.push_back(pack(value));
        }
        return array;
    }

    Json packed = Json::array();
};

class Unpacker {
public:
    explicit Unpacker(const Json& packed) : packed_(packed) {}
    template <class... T>
    void operator()(T&... values) {
        (unpack(packed_.at(next_++), values), ...);
    }
    template <class T>
    static void unpack(const Json& packed, T& value) {
        Unpacker inner(packed);
        members(inner, value);
    }
    static void unpack(const Json& packed, std::string& value) { packed.get_to(value); }
    static void unpack(const Json& packed, double& value) { packed.get_to(value); }
    static void unpack(const Json& packed, int& value) { packed.get_to(value); }
    static void unpack(const Json& packed, bool& value) { packed.get_to(value); }
    template <class E>
    requires std::is_enum_v<E>
    static void unpack(const Json& packed, E& value) { value = static_cast<E>(packed.get<int>()); }
    static void unpack(const Json& packed, const pave::material::Law*& law) {
        const auto name = packed.get<std::string>();
        for (const auto* candidate : pave::material::laws()) {
            if (candidate->name() == name) {
                law = candidate;
                return;
            }
        }
        throw std::runtime_error("no law is called " + name);
    }
    static void unpack(const Json& packed, const Effect*& effect) {
        effect = find_effect(packed.get<std::string>());
        if (effect == nullptr) {
            throw std::runtime_error("no effect is called " + packed.get<std::string>());
        }
    }
    static void unpack(const Json& packed, std::pair<std::string, std::string>& texts) { packed.get_to(texts); }
    static void unpack(const Json&, pave::fe::Field&) { throw std::runtime_error("fields do not travel"); }
    template <class T>
    static void unpack(const Json& packed, std::optional<T>& value) {
        value.reset();
        if (!packed.empty()) {
            unpack(packed.at(0), value.emplace());
        }
    }
    template <class T>
    static void unpack(const Json& packed, std::vector<T>& values) {
        values.resize(packed.size());
        for (std::size_t i = 0; i < values.size(); ++i) {
            unpack(packed.at(i), values[i]);
        }
    }

private:
    const Json& packed_;
    std::size_t next_ = 0;
};

template <class Archive, class T>
void members(Archive& archive, T& value) {
    using Own = std::remove_const_t<T>;
    if constexpr (std::is_same_v<Own, Layer>) {
        auto& [name, thickness, density, k0, residual_stress, law, parameters, fields, compliance, damping] = value;
        archive(name, thickness, density, k0, residual_stress, law, parameters, fields, compliance, damping);
    } else if constexpr (std::is_same_v<Own, Load>) {
        auto& [name, type, pressure, radius, force, spacing, wheels, patch, width, factor, shape, duration, stiffness,
               inertia, history, shift] = value;
        archive(name, type, pressure, radius, force, spacing, wheels, patch, width, factor, shape, duration, stiffness,
                inertia, history, shift);
    } else if constexpr (std::is_same_v<Own, Load::Sample>) {
        auto& [time, share] = value;
        archive(time, share);
    } else if constexpr (std::is_same_v<Own, Load::Wheel>) {
        auto& [x, y, force] = value;
        archive(x, y, force);
    } else if constexpr (std::is_same_v<Own, Sensor>) {
        auto& [load, quantity, x, y, depth, gauge, measured, gain, time, shares] = value;
        archive(load, quantity, x, y, depth, gauge, measured, gain, time, shares);
    } else if constexpr (std::is_same_v<Own, Sensor::Share>) {
        auto& [dx, gauge, weight] = value;
        archive(dx, gauge, weight);
    } else if constexpr (std::is_same_v<Own, pave::fe::SolverSettings>) {
        auto& [load_steps, equilibrium, linear, time_limit] = value;
        archive(load_steps, equilibrium, linear, time_limit);
    } else if constexpr (std::is_same_v<Own, Settings>) {
        auto& [integration, extent, wall_follows, refine, solver, layered, time_step, shares_paths] = value;
        archive(integration, extent, wall_follows, refine, solver, layered, time_step, shares_paths);
    } else if constexpr (std::is_same_v<Own, AppliedEffect>) {
        auto& [effect, size, present, layer, load, quantity, reading, thickness, offsets] = value;
        archive(effect, size, present, layer, load, quantity, reading, thickness, offsets);
    } else if constexpr (std::is_same_v<Own, Correction>) {
        auto& [channel, layer, places, factors, present] = value;
        archive(channel, layer, places, factors, present);
    } else {
        static_assert(std::is_same_v<Own, Case>);
        auto& [layers, loads, sensors, settings, effects, half_space, ties, corrections] = value;
        if constexpr (std::is_const_v<T>) {
            archive(layers, loads, sensors, settings, effects, half_space, corrections, ties);
        } else { // ties are made when all that they read is there
            std::vector<std::pair<std::string, std::string>> texts;
            archive(layers, loads, sensors, settings, effects, half_space, corrections, texts);
            for (const auto& [path, text] : texts) {
                add_tie(value, path, text, {});
            }
        }
    }
}

class PavementFunction final : public problem::ForwardFunction {
public:
    PavementFunction(const Case& model, const std::vector<Parameter>& parameters, const std::vector<bool>& loads)
        : model_(model, loads),
          parameters_(parameters),
          loads_(loads) {}

    std::unique_ptr<Workspace> make_workspace() const override {
        auto workspace = std::make_unique<Own>();
        workspace->own = model_.make_workspace();
        return workspace;
    }

    pave::Outcome<problem::Prediction> evaluate(std::span<const double> values, bool with_jacobian,
                                                Workspace& workspace) const override {
        auto outcome = respond(model_, parameters_, values, with_jacobian, *static_cast<Own&>(workspace).own);
        if (!outcome) {
            return outcome.failure();
        }
        return prediction_of(std::move(outcome).value(), with_jacobian);
    }

    std::vector<pave::Outcome<problem::Prediction>> evaluate_many(std::span<const std::vector<double>> points,
                                                                  bool with_jacobian,
                                                                  Workspace& workspace) const override {
        std::vector<Case> cases;
        std::vector<std::optional<pave::Failure>> impossible;
        for (const auto& values : points) {
            auto c = case_at(model_.nominal(), parameters_, values);
            impossible.push_back(c ? std::nullopt : std::optional(c.failure()));
            if (c) {
                cases.push_back(std::move(c).value());
            }
        }
        static const std::vector<Parameter> none;
        auto responses = model_.run_many(cases, with_jacobian ? parameters_ : none, *static_cast<Own&>(workspace).own);
        std::vector<pave::Outcome<problem::Prediction>> answers;
        auto next = responses.begin();
        for (const auto& why_not : impossible) {
            if (why_not) {
                answers.emplace_back(*why_not);
                continue;
            }
            auto& outcome = *next++;
            answers.push_back(outcome ? pave::Outcome(prediction_of(std::move(outcome).value(), with_jacobian))
                                      : pave::Outcome<problem::Prediction>(outcome.failure()));
        }
        return answers;
    }
    std::size_t lanes() const override { return static_cast<std::size_t>(model_.lanes()); }

    std::string description() const override {
        std::vector<std::string> paths;
        for (const Parameter& p : parameters_) {
            paths.push_back(p.path);
        }
        const Json all = Json::array({Packer::pack(model_.nominal()), paths, loads_});
        std::string bytes;
        Json::to_cbor(all, bytes); // doubles bit for bit, those that are not numbers included
        return bytes;
    }

private:
    struct Own : Workspace {
        ForwardModel::WorkspacePointer own;
    };
    ForwardModel model_;
    std::vector<Parameter> parameters_;
    std::vector<bool> loads_;
};

} // namespace

pave::Outcome<Case> case_at(const Case& model, const std::vector<Parameter>& parameters,
                            std::span<const double> values) {
    Case c = model;
    for (std::size_t k = 0; k < parameters.size(); ++k) {
        const Parameter& p = parameters[k];
        if (!((p.low_is_open ? values[k] > p.low : values[k] >= p.low) && values[k] <= p.high)) {
            return pave::Failure{pave::Status::invalid_parameters,
                                 fmt::format("{} = {:g} is out of its range: {:g} {} value <= {:g}", p.path, values[k],
                                             p.low, p.low_is_open ? "<" : "<=", p.high)};
        }
        p.in(c) = values[k] * p.to_si;
    }
    if (std::string wrong = apply_ties(c); !wrong.empty()) {
        return pave::Failure{pave::Status::invalid_parameters, std::move(wrong)};
    }
    return c;
}

pave::Outcome<Response> respond(const ForwardModel& model, const std::vector<Parameter>& parameters,
                                std::span<const double> values, bool with_jacobian,
                                ForwardModel::Workspace& workspace) {
    const auto c = case_at(model.nominal(), parameters, values);
    if (!c) {
        return c.failure();
    }
    static const std::vector<Parameter> none;
    return model.run(*c, with_jacobian ? parameters : none, workspace);
}

problem::Prediction prediction_of(Response response, bool with_jacobian) {
    return {std::move(response.values), with_jacobian ? std::move(response.jacobian) : Eigen::MatrixXd(),
            std::move(response.warnings)};
}

std::shared_ptr<const problem::ForwardFunction>
make_function(const Case& model, const std::vector<Parameter>& parameters, const std::vector<bool>& loads) {
    return std::make_shared<PavementFunction>(model, parameters, loads);
}

std::shared_ptr<const problem::ForwardFunction> make_function(const std::string& description) {
    try {
        if (external::is_description(description)) {
            return external::function_of(description);
        }
        const Json all = Json::from_cbor(description);
        Case model;
        Unpacker::unpack(all.at(0), model);
        std::vector<Parameter> parameters;
        for (const auto& path : all.at(1)) {
            parameters.push_back(find_parameter(model, path.get<std::string>(), {}));
        }
        return std::make_shared<PavementFunction>(model, parameters, all.at(2).get<std::vector<bool>>());
    } catch (const Json::exception& error) {
        throw std::runtime_error(std::string("this is no description of a forward model: ") + error.what());
    }
}

} // namespace explore::study
