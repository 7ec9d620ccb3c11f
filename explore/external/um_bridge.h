// A model behind a server that speaks UM-Bridge 1.0: HTTP and JSON (um-bridge-benchmarks.readthedocs.io).
#pragma once

#include "external/simulator.h"

#include <memory>
#include <nlohmann/json.hpp>

namespace explore::external {

struct ServerSettings {
    std::vector<std::string> urls; // http://host:port; several: each with the same model
    std::string name = "forward";  // of the model
    nlohmann::json config = nlohmann::json::object();
    std::size_t parameters = 0, responses = 0; // that it should have
    double time_limit = 0.0;                   // s, of a request; 0: none
};

// Its input vectors, one after the other, are the parameters; its output vectors the responses. Asked when it is first
// needed.
std::shared_ptr<const Simulator> make_client(ServerSettings settings);
std::shared_ptr<const Simulator> client_of(const nlohmann::json& description);

} // namespace explore::external
