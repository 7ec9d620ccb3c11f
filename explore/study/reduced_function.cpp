#include "study/reduced_function.h"

#include "data/hash.h"
#include "study/pavement_function.h"

#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

namespace explore::study {
namespace {

using namespace pave::pavement;
using Json = nlohmann::json;

// Of this layout of the file, and of the algorithm that builds.
constexpr int format_version = 7;

class ReducedFunction final : public problem::ForwardFunction {
public:
    ReducedFunction(std::shared_ptr<const problem::ForwardFunction> full, const Study& study, std::vector<bool> loads,
                    const ReducedLoads& reduced, double limit)
        : full_(std::move(full)),
          model_(study.model, models(study, reduced)),
          parameters_(study.parameters),
          loads_(std::move(loads)),
          limit_(limit) {}

    std::unique_ptr<Workspace> make_workspace() const override {
        auto workspace = std::make_unique<Own>();
        workspace->reduced = model_.make_workspace();
        return workspace;
    }

    pave::Outcome<problem::Prediction> evaluate(std::span<const double> values, bool with_jacobian,
                                                Workspace& workspace) const override {
        Own& own = static_cast<Own&>(workspace);
        auto outcome = respond(model_, parameters_, values, with_jacobian, *own.reduced);
        if (outcome.status() == pave::Status::invalid_parameters) {
            return outcome.failure();
        }
        if (outcome && is_sure(*outcome)) {
            return prediction_of(std::move(outcome).value(), with_jacobian);
        }
        if (own.full == nullptr) {
            own.full = full_->make_workspace();
        }
        auto answer = full_->evaluate(values, with_jacobian, *own.full);
        if (!answer) {
            return answer;
        }
        problem::Prediction prediction = std::move(answer).value();
        prediction.in_place_of_reduced = true;
        return prediction;
    }

private:
    struct Own : Workspace {
        ForwardModel::WorkspacePointer reduced;
        std::unique_ptr<Workspace> full; // made when it is needed
    };

    static std::vector<std::shared_ptr<const LoadModel>> models(const Study& study, const ReducedLoads& reduced) {
        std::vector<std::shared_ptr<const LoadModel>> list(reduced.size());
        for (std::size_t l = 0; l < reduced.size(); ++l) {
            if (reduced[l]) {
                list[l] = pave::reduced::make_load_model(study.model, static_cast<int>(l), reduced[l]->basis);
            }
        }
        return list;
    }

    // Whether the errors of all fitted readings are estimated within the limit; an estimate that is not a number is
    // none.
    bool is_sure(const Response& response) const {
        const Case& c = model_.nominal(); // whose sensors every point shares
        for (std::size_t l = 0; l < loads_.size(); ++l) {
            if (!loads_[l]) {
                continue;
            }
            const auto scale = pave::reduced::scales(c, static_cast<int>(l), response.values);
            for (std::size_t i = 0; i < scale.size(); ++i) {
                if (c.sensors[i].load == static_cast<int>(l) && !(response.errors[i] <= limit_ * scale[i])) {
                    return false;
                }
            }
        }
        return true;
    }

    std::shared_ptr<const problem::ForwardFunction> full_;
    ForwardModel model_;
    std::vector<Parameter> parameters_;
    std::vector<bool> loads_;
    double limit_;
};

constexpr std::ptrdiff_t hash_length = 32;

} // namespace

std::string why_no_reduced_model(const Study& study) {
    if (study.has_own_model) {
        return "a model of your own is not projected";
    }
    const auto loads = fitted_loads(study);
    for (std::size_t l = 0; l < loads.size(); ++l) {
        if (loads[l]) {
            if (std::string why = pave::reduced::why_not(study.model, static_cast<int>(l)); !why.empty()) {
                return fmt::format("load \"{}\": {}", study.model.loads[l].name, why);
            }
        }
    }
    // Of pulses the mesh may move.
    bool moves = true;
    for (std::size_t l = 0; l < loads.size(); ++l) {
        moves = moves && (!loads[l] || study.model.loads[l].is_pulse());
    }
    const auto why_not = [&](const Parameter& p) {
        return (p.changes_geometry() && !moves) || p.in_effect || p.in_correction
                   ? fmt::format("{} changes more than materials, initial stress and the size of the load", p.path)
                   : std::string();
    };
    for (const Parameter& p : study.parameters) {
        if (std::string why = why_not(p); !why.empty()) {
            return why;
        }
    }
    for (const Tie& tie : study.model.ties) {
        if (std::string why = why_not(find_parameter(study.model, tie.path, {})); !why.empty()) {
            return why;
        }
    }
    return {};
}

std::string reduced_key(const Study& study, std::size_t samples, const pave::reduced::BuildSettings& settings) {
    std::string text = fmt::format("{} {} {} {} ", format_version, samples, settings.most_runs, settings.calibration);
    text += make_function(study.model, study.parameters, fitted_loads(study))->description();
    for (const auto& axis : study.space.axes) {
        text += fmt::format("{} {:a} {:a} {} ", axis.name, axis.low, axis.high, static_cast<int>(axis.scale));
    }
    return data::hash_of(text);
}

pave::Outcome<ReducedLoads> build_reduced(const Study& study, const std::vector<std::vector<double>>& samples,
                                          const pave::reduced::BuildSettings& settings,
                                          const pave::reduced::ForEach& for_each) {
    std::vector<Case> cases;
    for (const auto& unit : samples) {
        auto c = case_at(study.model, study.parameters, study.space.physical(unit));
        if (!c) {
            return c.failure();
        }
        cases.push_back(std::move(c).value());
    }
    ReducedLoads reduced(study.model.loads.size());
    const auto loads = fitted_loads(study);
    for (std::size_t l = 0; l < loads.size(); ++l) {
        if (!loads[l]) {
            continue;
        }
        pave::reduced::BuildReport report;
        auto outcome = pave::reduced::build(study.model, static_cast<int>(l), cases, settings, for_each, &report);
        if (!outcome) {
            return outcome.failure();
        }
        reduced[l] = {std::move(outcome).value(), report};
    }
    return reduced;
}

void save_reduced(const std::string& file, const std::string& key, const ReducedLoads& loads) {
    Json list = Json::array();
    for (const auto& load : loads) {
        if (!load) {
            list.push_back(nullptr);
            continue;
        }
        const std::string basis = pave::reduced::packed(load->basis);
        list.push_back({{"basis", Json::binary({basis.begin(), basis.end()})},
                        {"full_runs", load->report.full_runs},
                        {"error_95", load->report.error_95}});
    }
    std::string bytes;
    Json::to_cbor(Json{{"key", key}, {"loads", list}}, bytes);
    std::ofstream out(file, std::ios::binary);
    out << data::hash_of(bytes) << bytes;
    out.flush();
    if (!out) {
        throw pave::Error({.file = file}, "the reduced model cannot be written", {}, "a folder with room");
    }
}

std::optional<ReducedLoads> load_reduced(const std::string& file, const std::string& key) {
    std::ifstream in(file, std::ios::binary);
    std::stringstream bytes;
    bytes << in.rdbuf();
    const std::string all = bytes.str();
    if (!in || all.size() < static_cast<std::size_t>(hash_length) ||
        data::hash_of(all.substr(hash_length)) != all.substr(0, hash_length)) {
        return std::nullopt;
    }
    const Json json = Json::from_cbor(all.begin() + hash_length, all.end());
    if (json.at("key") != key) {
        return std::nullopt;
    }
    ReducedLoads loads;
    for (const Json& load : json.at("loads")) {
        auto& reduced = loads.emplace_back();
        if (load.is_null()) {
            continue;
        }
        const auto& bytes_of_basis = load.at("basis").get_binary();
        auto basis = pave::reduced::unpacked({bytes_of_basis.begin(), bytes_of_basis.end()});
        if (!basis) {
            return std::nullopt;
        }
        reduced.emplace();
        reduced->report = {.full_runs = load.at("full_runs"),
                           .modes = static_cast<int>(basis->modes.cols()),
                           .points = static_cast<int>(basis->points.size()),
                           .error_95 = load.at("error_95")};
        reduced->basis = std::move(*basis);
    }
    return loads;
}

problem::Problem with_reduced_model(problem::Problem fitted, const Study& study, const ReducedLoads& loads,
                                    double limit) {
    fitted.function = std::make_shared<ReducedFunction>(fitted.function, study, fitted_loads(study), loads, limit);
    return fitted;
}

} // namespace explore::study
