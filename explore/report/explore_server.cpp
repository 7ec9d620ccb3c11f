#include "report/explore_server.h"

#include "base/error.h"
#include "report/explore.h"
#include "report/loopback_server.h"
#include "report/page.h"

#include <charconv>
#include <fmt/format.h>
#include <httplib.h>
#include <random>
#include <stdexcept>

namespace explore::report {
namespace {

std::string make_token() {
    std::random_device random; // of the operating system
    std::string token;
    for (int i = 0; i < 4; ++i) {
        token += fmt::format("{:08x}", static_cast<std::uint32_t>(random()));
    }
    return token;
}

// Takes the same time wherever they differ.
bool same(const std::string& a, const std::string& b) {
    unsigned differs = a.size() == b.size() ? 0 : 1;
    for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) {
        differs |= static_cast<unsigned>(a[i] ^ b[i]);
    }
    return differs == 0;
}

template <class Number>
Number number_of(std::string_view text, const char* what) {
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) {
        throw std::invalid_argument(fmt::format("{}: \"{}\" is not a number", what, text.substr(0, 40)));
    }
    return value;
}

// Calls part(text) for each of a list separated by commas; an empty list has none.
template <class Part>
void each_of(std::string_view list, const Part& part) {
    while (!list.empty()) {
        const auto comma = list.find(',');
        part(list.substr(0, comma));
        list = comma == std::string_view::npos ? std::string_view{} : list.substr(comma + 1);
    }
}

std::vector<double> point_of(const httplib::Request& request) {
    std::vector<double> values;
    const std::string list = request.get_param_value("at");
    each_of(list, [&](std::string_view text) { values.push_back(number_of<double>(text, "at")); });
    return values;
}

analysis::ChangedReadings changes_of(const httplib::Request& request) {
    analysis::ChangedReadings changes;
    const std::string list = request.get_param_value("changed");
    each_of(list, [&](std::string_view text) {
        const auto colon = text.find(':');
        if (colon == std::string_view::npos) {
            throw std::invalid_argument("changed: READING:VALUE is wanted");
        }
        changes.emplace_back(number_of<std::size_t>(text.substr(0, colon), "changed"),
                             number_of<double>(text.substr(colon + 1), "changed"));
    });
    return changes;
}

class Guard {
public:
    Guard(std::string token, int port)
        : token_(std::move(token)),
          hosts_{fmt::format("{}:{}", loopback, port), fmt::format("localhost:{}", port)} {}

    bool admits(const httplib::Request& request) const {
        // A page of another site may make a browser ask; it cannot make it name this host, nor know the token.
        const auto names_us = [&](const std::string& host) { return host == hosts_[0] || host == hosts_[1]; };
        if (request.get_header_value_count("Host") != 1 || !names_us(request.get_header_value("Host"))) {
            return false;
        }
        if (request.has_header("Origin")) {
            const std::string origin = request.get_header_value("Origin");
            constexpr std::string_view scheme = "http://";
            if (!origin.starts_with(scheme) || !names_us(origin.substr(scheme.size()))) {
                return false;
            }
        }
        return request.get_param_value_count("token") == 1 && same(request.get_param_value("token"), token_);
    }

private:
    std::string token_;
    std::string hosts_[2];
};

void answer(httplib::Server& server, const std::string& path,
            const std::function<Json(const httplib::Request& request)>& make) {
    server.Get(path, [make](const httplib::Request& request, httplib::Response& response) {
        Json json;
        try {
            json = make(request);
        } catch (const std::invalid_argument& error) {
            response.status = 400;
            json = {{"error", error.what()}};
        } catch (const std::exception& error) {
            response.status = 500;
            json = {{"error", error.what()}};
        }
        response.set_content(json_text(json, -1), "application/json");
    });
}

void route(httplib::Server& server, analysis::Explorer& explorer) {
    server.Get("/", [](const httplib::Request&, httplib::Response& response) {
        response.set_content(explore_page(), "text/html; charset=utf-8");
    });
    answer(server, "/state", [&](const httplib::Request&) { return explore_state_json(explorer); });
    answer(server, "/evaluate", [&](const httplib::Request& request) {
        const auto changes = changes_of(request);
        return explore_point_json(explorer, explorer.evaluate(point_of(request), changes), changes);
    });
    answer(server, "/fit", [&](const httplib::Request& request) {
        const auto changes = changes_of(request);
        return explore_fit_json(explorer, explorer.fit(point_of(request), changes), changes);
    });
    answer(server, "/landscape", [&](const httplib::Request& request) {
        const auto whole = [&](const char* name) { return number_of<unsigned>(request.get_param_value(name), name); };
        return explore_landscape_json(
            explorer, explorer.landscape(whole("x"), whole("y"), point_of(request), changes_of(request),
                                         static_cast<int>(std::min(whole("lines"), 1000U)), whole("fitted") != 0));
    });
    answer(server, "/confirm", [&](const httplib::Request& request) {
        const auto changes = changes_of(request);
        return explore_confirm_json(explorer, explorer.confirm(point_of(request), changes), changes);
    });
}

} // namespace

void serve_explorer(analysis::Explorer& explorer, int wanted_port,
                    const std::function<void(const std::string& address)>& ready) {
    httplib::Server server;
    server.set_default_headers({{"Cache-Control", "no-store"},
                                {"Referrer-Policy", "no-referrer"},
                                {"X-Content-Type-Options", "nosniff"},
                                {"X-Frame-Options", "DENY"},
                                {"Cross-Origin-Resource-Policy", "same-origin"}});
    const int port = bind_to_loopback(server, wanted_port);
    const std::string token = make_token();
    const Guard guard(token, port);
    server.set_pre_routing_handler([&](const httplib::Request& request, httplib::Response& response) {
        if (guard.admits(request)) {
            return httplib::Server::HandlerResponse::Unhandled;
        }
        response.status = 403;
        return httplib::Server::HandlerResponse::Handled;
    });
    route(server, explorer);
    listen_until_interrupted(server, [&] { ready(fmt::format("http://{}:{}/?token={}", loopback, port, token)); });
}

} // namespace explore::report
