#include "report/model_server.h"

#include "base/text.h"
#include "problem/workspaces.h"
#include "report/loopback_server.h"
#include "run/parallel.h"

#include <condition_variable>
#include <deque>
#include <fmt/format.h>
#include <httplib.h>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

namespace explore::report {
namespace {

using Message = nlohmann::json;
using Eigen::Index;

constexpr const char* model_name = "forward";

// An error as the protocol says it.
struct ProtocolError : std::runtime_error {
    ProtocolError(std::string kind, const std::string& message, int http = 400)
        : std::runtime_error(message),
          type(std::move(kind)),
          status(http) {}
    std::string type;
    int status;
};

class ServedModel {
public:
    ServedModel(const study::Study& study, int threads)
        : problem_(study::make_prediction_problem(study)),
          free_(threads) {
        for (const data::Reading& reading : study.readings) {
            to_si_.push_back(reading.unit.to_si);
        }
    }

    std::size_t inputs() const { return problem_.space.axes.size(); }
    std::size_t outputs() const { return to_si_.size(); }

    Message evaluate(const Message& request) {
        const problem::Prediction prediction = at(point_of(request), false);
        std::vector<double> values;
        for (std::size_t i = 0; i < to_si_.size(); ++i) {
            values.push_back(prediction.responses[i] / to_si_[i]);
        }
        return {{"output", {values}}};
    }

    Message gradient(const Message& request) {
        const Eigen::VectorXd by = vector_of(request, "sens", outputs());
        return {{"output", list_of(jacobian(request).transpose() * by)}};
    }

    Message apply_jacobian(const Message& request) {
        const Eigen::VectorXd by = vector_of(request, "vec", inputs());
        return {{"output", list_of(jacobian(request) * by)}};
    }

private:
    static std::vector<double> list_of(const Eigen::VectorXd& vector) { return {vector.begin(), vector.end()}; }

    static const Message& member(const Message& request, const char* name) {
        const auto found = request.find(name);
        if (found == request.end()) {
            throw ProtocolError("InvalidInput", fmt::format("the request has no {}", name));
        }
        return *found;
    }

    static std::vector<double> numbers(const Message& list, const std::string& what, std::size_t size) {
        if (!list.is_array() || list.size() != size) {
            throw ProtocolError("InvalidInput",
                                fmt::format("{} has invalid length: {} is wanted, {} found", what, size,
                                            list.is_array() ? fmt::format("{}", list.size()) : "no list"));
        }
        std::vector<double> values;
        for (const Message& value : list) {
            if (!value.is_number()) {
                throw ProtocolError("InvalidInput", fmt::format("{} holds {}, which is not a number", what,
                                                                pave::printable(value.dump(-1, ' ', true), 40)));
            }
            values.push_back(value.get<double>());
        }
        return values;
    }

    std::vector<double> point_of(const Message& request) const {
        const Message& input = member(request, "input");
        if (!input.is_array() || input.size() != 1) {
            throw ProtocolError("InvalidInput", "the model has one input vector");
        }
        return numbers(input[0], "input vector 0", inputs());
    }

    Eigen::VectorXd vector_of(const Message& request, const char* name, std::size_t size) const {
        for (const char* index : {"outWrt", "inWrt"}) {
            if (member(request, index) != 0) {
                throw ProtocolError("InvalidInput", fmt::format("{} is not 0: the model has one input and one output "
                                                                "vector",
                                                                index));
            }
        }
        const std::vector<double> values = numbers(member(request, name), name, size);
        return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Index>(size));
    }

    Eigen::MatrixXd jacobian(const Message& request) {
        Eigen::MatrixXd result = at(point_of(request), true).jacobian;
        for (Index i = 0; i < result.rows(); ++i) {
            result.row(i) /= to_si_[static_cast<std::size_t>(i)];
        }
        return result;
    }

    // Of the points with derivatives the last few are remembered: who wants a whole Jacobian asks for it in columns.
    problem::Prediction at(const std::vector<double>& point, bool with_jacobian) {
        {
            std::unique_lock lock(mutex_);
            turn_.wait(lock, [&] { return free_ > 0; });
            for (const auto& [known, prediction] : recent_) {
                if (known == point) {
                    return prediction;
                }
            }
            --free_;
        }
        auto outcome = workspaces_.lend(
            [&](auto& workspace) { return problem_.function->evaluate(point, with_jacobian, workspace); });
        {
            const std::scoped_lock lock(mutex_);
            ++free_;
            if (outcome && with_jacobian) {
                constexpr std::size_t most = 32;
                recent_.emplace_front(point, *outcome);
                recent_.resize(std::min(recent_.size(), most));
            }
        }
        turn_.notify_one();
        if (!outcome) {
            const bool is_input = outcome.status() == pave::Status::invalid_parameters;
            throw ProtocolError(is_input ? "InvalidInput" : "InvalidOutput",
                                fmt::format("{}: {}", to_string(outcome.status()), outcome.failure().reason),
                                is_input ? 400 : 500);
        }
        return std::move(outcome).value();
    }

    problem::Problem problem_;
    std::vector<double> to_si_;
    std::mutex mutex_;
    std::condition_variable turn_;
    int free_;
    problem::Workspaces workspaces_{*problem_.function}; // no more than threads
    std::deque<std::pair<std::vector<double>, problem::Prediction>> recent_;
};

void answer_posts(httplib::Server& server, const std::string& path,
                  const std::function<Message(const Message& request)>& make) {
    server.Post(path, [make](const httplib::Request& request, httplib::Response& response) {
        Message answer;
        try {
            const Message asked = Message::parse(request.body, nullptr, false);
            if (!asked.is_object()) {
                throw ProtocolError("InvalidInput", "the request is no JSON object");
            }
            if (const Message name = asked.value("name", Message()); name != model_name) {
                throw ProtocolError("ModelNotFound",
                                    fmt::format("there is no model {}; there is \"{}\"",
                                                pave::printable(name.dump(-1, ' ', true), 60), model_name));
            }
            answer = make(asked);
        } catch (const ProtocolError& error) {
            response.status = error.status;
            answer = {{"error", {{"type", error.type}, {"message", error.what()}}}};
        } catch (const std::exception& error) {
            response.status = 500;
            answer = {{"error", {{"type", "InvalidOutput"}, {"message", error.what()}}}};
        }
        response.set_content(answer.dump(-1, ' ', true), "application/json");
    });
}

void route_protocol(httplib::Server& server, ServedModel& model) {
    server.Get("/Info", [](const httplib::Request&, httplib::Response& response) {
        response.set_content(Message{{"protocolVersion", 1.0}, {"models", {model_name}}}.dump(), "application/json");
    });
    answer_posts(server, "/ModelInfo", [](const Message&) -> Message {
        return {
            {"support", {{"Evaluate", true}, {"Gradient", true}, {"ApplyJacobian", true}, {"ApplyHessian", false}}}};
    });
    answer_posts(server, "/InputSizes", [&](const Message&) -> Message { return {{"inputSizes", {model.inputs()}}}; });
    answer_posts(server, "/OutputSizes", [&](const Message&) -> Message {
        return {{"outputSizes", {model.outputs()}}};
    });
    answer_posts(server, "/Evaluate", [&](const Message& request) { return model.evaluate(request); });
    answer_posts(server, "/Gradient", [&](const Message& request) { return model.gradient(request); });
    answer_posts(server, "/ApplyJacobian", [&](const Message& request) { return model.apply_jacobian(request); });
    answer_posts(server, "/ApplyHessian", [](const Message&) -> Message {
        throw ProtocolError("UnsupportedFeature", "second derivatives are not offered");
    });
}

} // namespace

void serve_model(const study::Study& study, int wanted_port, int threads,
                 const std::function<void(const std::string& address)>& ready) {
    ServedModel model(study, run::usable_threads(threads));
    httplib::Server server;
    constexpr std::size_t connections = 64; // each waits in a thread of its own
    server.new_task_queue = [] { return new httplib::ThreadPool(connections); };
    constexpr std::size_t largest_request = std::size_t{1} << 24U;
    server.set_payload_max_length(largest_request);
    const int port = bind_to_loopback(server, wanted_port);
    server.set_pre_routing_handler([&](const httplib::Request& request, httplib::Response& response) {
        // A page of another site may make a browser ask; it cannot make it name this host without an Origin.
        const std::string host = request.get_header_value("Host");
        if ((host == fmt::format("{}:{}", loopback, port) || host == fmt::format("localhost:{}", port)) &&
            !request.has_header("Origin")) {
            return httplib::Server::HandlerResponse::Unhandled;
        }
        response.status = 403;
        return httplib::Server::HandlerResponse::Handled;
    });
    route_protocol(server, model);
    listen_until_interrupted(server, [&] { ready(fmt::format("http://{}:{}", loopback, port)); });
}

} // namespace explore::report
