#include "external/um_bridge.h"

#include "base/error.h"
#include "base/passing_failure.h"
#include "base/text.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <httplib.h>
#include <mutex>
#include <numeric>
#include <stdexcept>

namespace explore::external {
namespace {

using Json = nlohmann::json;

// Errors that become a Failure.
struct NoAnswer : std::runtime_error {
    using std::runtime_error::runtime_error;
};

[[noreturn]] void no_answer_now(const std::string& reason) {
    throw NoAnswer(fmt::format("{} ({})", reason, pave::passing_words));
}

// Connections to one server that nobody uses.
struct Server {
    std::string url;
    int asked = 0; // requests under way
    std::vector<std::unique_ptr<httplib::Client>> idle{};
};

class Client final : public Simulator {
public:
    explicit Client(ServerSettings settings) : settings_(std::move(settings)) {
        for (const std::string& url : settings_.urls) {
            servers_.push_back({.url = url});
        }
    }

    pave::Outcome<std::vector<double>> run(std::span<const double> values) const override {
        return guarded<std::vector<double>>([&] {
            const Shape& shape = this->shape();
            Json request = common();
            request["input"] = shape.inputs_of(values);
            const Json answer = ask("/Evaluate", request);
            const Json& output = answer.at("output");
            std::vector<double> responses;
            for (std::size_t o = 0; o < output.size(); ++o) {
                const auto part = numbers_of(output.at(o), o < shape.outputs.size() ? shape.outputs[o] : 0);
                responses.insert(responses.end(), part.begin(), part.end());
            }
            if (responses.size() != settings_.responses) {
                throw NoAnswer(fmt::format("the server answered {} instead of {}",
                                           pave::counted(responses.size(), "number", "numbers"), settings_.responses));
            }
            return responses;
        });
    }

    bool has_jacobian() const override {
        const auto known = guarded<bool>([&] { return shape().has_gradient || shape().has_jacobian; });
        return !known || *known;
    }

    pave::Outcome<Eigen::MatrixXd> jacobian(std::span<const double> values) const override {
        return guarded<Eigen::MatrixXd>([&] { return jacobian_of(shape(), values); });
    }

    std::string description() const override {
        return Json{{"type", "um-bridge"},
                    {"urls", settings_.urls},
                    {"name", settings_.name},
                    {"config", settings_.config},
                    {"parameters", settings_.parameters},
                    {"responses", settings_.responses},
                    {"time_limit", settings_.time_limit}}
            .dump();
    }

    void keep_in(const std::string&) const override {}
    std::string kept_words() const override { return ""; }

private:
    // Sizes of the vectors that the model takes and gives, and what it offers.
    struct Shape {
        std::vector<std::size_t> inputs, outputs;
        bool has_gradient = false;
        bool has_jacobian = false;

        Json inputs_of(std::span<const double> values) const {
            Json list = Json::array();
            std::size_t at = 0;
            for (const std::size_t size : inputs) {
                const auto part = values.subspan(at, size);
                list.push_back(std::vector<double>(part.begin(), part.end()));
                at += size;
            }
            return list;
        }
    };

    template <class T, class F>
    static pave::Outcome<T> guarded(const F& compute) {
        try {
            return compute();
        } catch (const NoAnswer& none) {
            return pave::Failure{pave::Status::failed, none.what()};
        } catch (const Json::exception&) {
            return pave::Failure{pave::Status::failed, "the server's answer is not as UM-Bridge 1.0 says"};
        }
    }

    Json common() const { return {{"name", settings_.name}, {"config", settings_.config}}; }

    static std::vector<double> numbers_of(const Json& list, std::size_t size) {
        std::vector<double> numbers;
        for (const Json& value : list) {
            if (!value.is_number() || !std::isfinite(value.get<double>())) {
                throw NoAnswer(fmt::format("the server answered {} where a finite number is wanted",
                                           pave::printable(value.dump(-1, ' ', true), 40)));
            }
            numbers.push_back(value.get<double>());
        }
        if (numbers.size() != size) {
            throw NoAnswer(fmt::format("the server answered {} instead of {}",
                                       pave::counted(numbers.size(), "number", "numbers"), size));
        }
        return numbers;
    }

    const Shape& shape() const {
        const std::scoped_lock lock(shape_mutex_);
        if (shape_) {
            return *shape_;
        }
        const Json info = ask("/Info", Json());
        if (const Json version = info.value("protocolVersion", Json()); version != 1.0) {
            no_answer_now("the server speaks UM-Bridge " + version.dump() + ", where 1.0 is wanted");
        }
        const auto models = info.at("models").get<std::vector<std::string>>();
        if (std::find(models.begin(), models.end(), settings_.name) == models.end()) {
            no_answer_now(fmt::format("the server has no model \"{}\"; it has {}", settings_.name, pave::join(models)));
        }
        Shape shape;
        const Json support = ask("/ModelInfo", common()).at("support");
        shape.has_gradient = support.value("Gradient", false);
        shape.has_jacobian = support.value("ApplyJacobian", false);
        ask("/InputSizes", common()).at("inputSizes").get_to(shape.inputs);
        ask("/OutputSizes", common()).at("outputSizes").get_to(shape.outputs);
        const auto sum = [](const auto& sizes) { return std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}); };
        if (sum(shape.inputs) != settings_.parameters || sum(shape.outputs) != settings_.responses) {
            no_answer_now(
                fmt::format("the server's model takes {} and gives {}; the study has {} and {}",
                            pave::counted(sum(shape.inputs), "number", "numbers"), sum(shape.outputs),
                            pave::counted(settings_.parameters, "parameter", "parameters"),
                            pave::counted(settings_.responses, "reading and output", "readings and outputs")));
        }
        shape_ = std::move(shape);
        return *shape_;
    }

    // By products with the Jacobian or by gradients, whichever are fewer.
    Eigen::MatrixXd jacobian_of(const Shape& shape, std::span<const double> values) const {
        Eigen::MatrixXd result(static_cast<Eigen::Index>(settings_.responses),
                               static_cast<Eigen::Index>(settings_.parameters));
        const bool by_columns =
            shape.has_jacobian && (!shape.has_gradient || settings_.parameters <= settings_.responses);
        Json request = common();
        request["input"] = shape.inputs_of(values);
        Eigen::Index row = 0;
        for (std::size_t o = 0; o < shape.outputs.size(); ++o) {
            Eigen::Index column = 0;
            for (std::size_t i = 0; i < shape.inputs.size(); ++i) {
                request["outWrt"] = o;
                request["inWrt"] = i;
                const std::size_t count = by_columns ? shape.inputs[i] : shape.outputs[o];
                for (std::size_t k = 0; k < count; ++k) {
                    std::vector<double> unit(count, 0.0);
                    unit[k] = 1.0;
                    request[by_columns ? "vec" : "sens"] = unit;
                    const Json answer = ask(by_columns ? "/ApplyJacobian" : "/Gradient", request);
                    const auto part = numbers_of(answer.at("output"), by_columns ? shape.outputs[o] : shape.inputs[i]);
                    for (std::size_t j = 0; j < part.size(); ++j) {
                        const auto own = static_cast<Eigen::Index>(k);
                        const auto other = static_cast<Eigen::Index>(j);
                        (by_columns ? result(row + other, column + own) : result(row + own, column + other)) = part[j];
                    }
                }
                column += static_cast<Eigen::Index>(shape.inputs[i]);
            }
            row += static_cast<Eigen::Index>(shape.outputs[o]);
        }
        return result;
    }

    // A request without a body is GET. Throws NoAnswer.
    Json ask(const std::string& path, const Json& request) const {
        std::size_t server = 0;
        std::unique_ptr<httplib::Client> client;
        {
            const std::scoped_lock lock(mutex_);
            const auto least = std::min_element(servers_.begin(), servers_.end(),
                                                [](const Server& a, const Server& b) { return a.asked < b.asked; });
            server = static_cast<std::size_t>(least - servers_.begin());
            ++least->asked;
            if (!least->idle.empty()) {
                client = std::move(least->idle.back());
                least->idle.pop_back();
            }
        }
        const std::string& url = servers_[server].url;
        if (client == nullptr) {
            client = std::make_unique<httplib::Client>(url);
            client->set_keep_alive(true);
            client->set_tcp_nodelay(true); // else a request in two parts waits 40 ms for an acknowledgement
            client->set_connection_timeout(5);
            constexpr double no_limit = 1e7;
            client->set_read_timeout(std::chrono::milliseconds(
                static_cast<std::int64_t>(1e3 * (settings_.time_limit > 0.0 ? settings_.time_limit : no_limit))));
        }
        const httplib::Result result =
            request.is_null() ? client->Get(path) : client->Post(path, request.dump(), "application/json");
        {
            const std::scoped_lock lock(mutex_);
            --servers_[server].asked;
            if (result) {
                servers_[server].idle.push_back(std::move(client));
            }
        }
        if (!result) {
            const bool late = result.error() == httplib::Error::Read && settings_.time_limit > 0.0;
            no_answer_now(
                late ? fmt::format("the server at {} did not answer within time_limit_s = {:g}, or broke off", url,
                                   settings_.time_limit)
                     : fmt::format("the server at {} does not answer: {}", url, httplib::to_string(result.error())));
        }
        const Json answer = Json::parse(result->body, nullptr, false);
        if (answer.is_object() && answer.contains("error")) {
            const Json& error = answer["error"];
            throw NoAnswer(fmt::format("the server's model has no answer: {}: {}", error.value("type", "error"),
                                       pave::printable(error.value("message", ""), 500)));
        }
        if (result->status != 200 || !answer.is_object()) {
            no_answer_now(fmt::format("the server at {} answered {} to {}", url, result->status, path));
        }
        return answer;
    }

    ServerSettings settings_;
    mutable std::mutex mutex_, shape_mutex_;
    mutable std::vector<Server> servers_;
    mutable std::optional<Shape> shape_;
};

} // namespace

std::shared_ptr<const Simulator> make_client(ServerSettings settings) {
    return std::make_shared<Client>(std::move(settings));
}

std::shared_ptr<const Simulator> client_of(const Json& all) {
    return make_client({.urls = all.at("urls").get<std::vector<std::string>>(),
                        .name = all.at("name"),
                        .config = all.at("config"),
                        .parameters = all.at("parameters"),
                        .responses = all.at("responses"),
                        .time_limit = all.at("time_limit")});
}

} // namespace explore::external
