#include "report/loopback_server.h"

#include "base/error.h"
#include "run/interrupt.h"

#include <atomic>
#include <chrono>
#include <fmt/format.h>
#include <httplib.h>
#include <thread>

namespace explore::report {

int bind_to_loopback(httplib::Server& server, int wanted_port) {
    server.set_tcp_nodelay(true);
    server.set_socket_options([](socket_t socket) { // not that another program may listen there too
        const int yes = 1;
        setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
    });
    server.set_keep_alive_max_count(1'000'000); // a slider or a sampler asks many times
    server.set_keep_alive_timeout(1);           // s; a stop waits so long for idle connections
    const int port = wanted_port == 0                             ? server.bind_to_any_port(loopback)
                     : server.bind_to_port(loopback, wanted_port) ? wanted_port
                                                                  : -1;
    if (port <= 0) {
        throw pave::Error({.key = "--port"}, "nothing can listen there", fmt::format("{}", wanted_port),
                          "a port that is free, or 0 for any");
    }
    return port;
}

void listen_until_interrupted(httplib::Server& server, const std::function<void()>& ready) {
    std::atomic<bool> ended{false};
    std::thread listener([&] {
        server.listen_after_bind();
        ended = true;
    });
    while (!server.is_running() && !ended) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ready();
    while (!run::interrupted() && !ended) {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    server.stop();
    listener.join();
}

} // namespace explore::report
