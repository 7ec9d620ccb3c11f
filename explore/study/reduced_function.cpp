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
constexpr int format_version = 3;

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
        if (outcome && largest_error(*outcome) <= limit_) {
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

    double largest_error(const Response& response) const {
        const Case& c = model_.nominal(); // whose sensors every point shares
        double largest = 0.0;
        for (std::size_t l = 0; l < loads_.size(); ++l) {
            if (!loads_[l]) {
                continue;
            }
            const auto scale = pave::reduced::scales(c, static_cast<int>(l), response.values);
            for (std::size_t i = 0; i < scale.size(); ++i) {
                if (c.sensors[i].load == static_cast<int>(l)) {
                    largest = std::max(largest, response.errors[i] / scale[i]);
                }
            }
        }
        return largest;
    }

    std::shared_ptr<const problem::ForwardFunction> full_;
    ForwardModel model_;
    std::vector<Parameter> parameters_;
    std::vector<bool> loads_;
    double limit_;
};

constexpr std::ptrdiff_t hash_length = 32;
template <class T>
Json packed(const T* data, std::size_t count) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(data);
    return Json::binary({bytes, bytes + count * sizeof(T)});
}

Json packed(const Eigen::MatrixXd& matrix) {
    return packed(matrix.data(), static_cast<std::size_t>(matrix.size()));
}

template <class T>
std::vector<T> unpacked(const Json& json) {
    const auto& bytes = json.get_binary();
    std::vector<T> values(bytes.size() / sizeof(T));
    std::copy(bytes.begin(), bytes.end(), reinterpret_cast<std::uint8_t*>(values.data()));
    return values;
}

Eigen::MatrixXd unpacked(const Json& json, Eigen::Index rows) {
    const auto numbers = unpacked<double>(json);
    return Eigen::MatrixXd::Map(numbers.data(), rows,
                                static_cast<Eigen::Index>(numbers.size()) / std::max<Eigen::Index>(rows, 1));
}

Eigen::VectorXd unpacked_vector(const Json& json) {
    const auto numbers = unpacked<double>(json);
    return Eigen::VectorXd::Map(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

} // namespace

std::string why_no_reduced_model(const Study& study) {
    const auto loads = fitted_loads(study);
    for (std::size_t l = 0; l < loads.size(); ++l) {
        if (loads[l]) {
            if (std::string why = pave::reduced::why_not(study.model, static_cast<int>(l)); !why.empty()) {
                return fmt::format("load \"{}\": {}", study.model.loads[l].name, why);
            }
        }
    }
    for (const Parameter& p : study.parameters) {
        if (p.changes_geometry() || p.in_effect) {
            return fmt::format("{} changes more than materials, initial stress and the size of the load", p.path);
        }
    }
    return {};
}

std::string reduced_key(const Study& study, std::size_t samples) {
    std::string text = fmt::format("{} {} ", format_version, samples);
    text += make_function(study.model, study.parameters, fitted_loads(study))->description();
    for (const auto& axis : study.space.axes) {
        text += fmt::format("{} {:a} {:a} {} ", axis.name, axis.low, axis.high, static_cast<int>(axis.scale));
    }
    return data::hash_of(text);
}

pave::Outcome<ReducedLoads> build_reduced(const Study& study, const std::vector<std::vector<double>>& samples,
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
        auto outcome = pave::reduced::build(study.model, static_cast<int>(l), cases, {}, for_each, &report);
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
        const auto& basis = load->basis;
        std::vector<int> places;
        std::vector<double> weights;
        for (const auto& point : basis.points) {
            places.push_back(point.gauss);
            weights.push_back(point.weight);
        }
        std::vector<int> kinds, layers, indices, logarithmic;
        std::vector<double> lows, highs;
        for (const auto& c : basis.coordinates) {
            kinds.push_back(static_cast<int>(c.kind));
            layers.push_back(c.layer);
            indices.push_back(static_cast<int>(c.index));
            logarithmic.push_back(c.logarithmic ? 1 : 0);
            lows.push_back(c.low);
            highs.push_back(c.high);
        }
        Json corrections = Json::array();
        for (const pave::reduced::Kriging& c : basis.correction) {
            corrections.push_back({{"lengths", packed(c.lengths)},
                                   {"places", packed(c.places)},
                                   {"factors", packed(c.factors)},
                                   {"mean", packed(&c.mean, 1)}});
        }
        list.push_back({{"free_unknowns", basis.modes.rows()},
                        {"modes", packed(basis.modes.data(), static_cast<std::size_t>(basis.modes.size()))},
                        {"coarse", basis.coarse},
                        {"points", packed(places.data(), places.size())},
                        {"weights", packed(weights.data(), weights.size())},
                        {"coordinates",
                         {{"kind", kinds},
                          {"layer", layers},
                          {"index", indices},
                          {"logarithmic", logarithmic},
                          {"low", packed(lows.data(), lows.size())},
                          {"high", packed(highs.data(), highs.size())}}},
                        {"correction", corrections},
                        {"factor", packed(basis.factor.data(), basis.factor.size())},
                        {"floor", packed(basis.floor.data(), basis.floor.size())},
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
        reduced.emplace();
        auto& basis = reduced->basis;
        const auto free_unknowns = load.at("free_unknowns").get<Eigen::Index>();
        basis.modes = unpacked(load.at("modes"), free_unknowns);
        load.at("coarse").get_to(basis.coarse);
        const auto places = unpacked<int>(load.at("points"));
        const auto weights = unpacked<double>(load.at("weights"));
        for (std::size_t i = 0; i < places.size(); ++i) {
            basis.points.push_back({places[i], weights[i]});
        }
        const Json& by = load.at("coordinates");
        const auto lows = unpacked<double>(by.at("low"));
        const auto highs = unpacked<double>(by.at("high"));
        for (std::size_t c = 0; c < lows.size(); ++c) {
            basis.coordinates.push_back({.kind = static_cast<pave::fe::Variation::Kind>(by.at("kind")[c].get<int>()),
                                         .layer = by.at("layer")[c].get<int>(),
                                         .index = by.at("index")[c].get<std::size_t>(),
                                         .logarithmic = by.at("logarithmic")[c].get<int>() != 0,
                                         .low = lows[c],
                                         .high = highs[c]});
        }
        for (const Json& correction : load.at("correction")) {
            basis.correction.push_back(
                {.lengths = unpacked_vector(correction.at("lengths")),
                 .places = unpacked(correction.at("places"), static_cast<Eigen::Index>(basis.coordinates.size())),
                 .factors = unpacked_vector(correction.at("factors")),
                 .mean = unpacked<double>(correction.at("mean")).at(0)});
        }
        basis.factor = unpacked<double>(load.at("factor"));
        basis.floor = unpacked<double>(load.at("floor"));
        reduced->report = {.full_runs = load.at("full_runs"),
                           .modes = static_cast<int>(basis.modes.cols()),
                           .points = static_cast<int>(basis.points.size()),
                           .error_95 = load.at("error_95")};
    }
    return loads;
}

problem::Problem with_reduced_model(problem::Problem fitted, const Study& study, const ReducedLoads& loads,
                                    double limit) {
    fitted.function = std::make_shared<ReducedFunction>(fitted.function, study, fitted_loads(study), loads, limit);
    return fitted;
}

} // namespace explore::study
