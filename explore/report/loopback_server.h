// Shared by servers for this machine alone: where they listen, and until when.
#pragma once

#include <functional>
#include <string>

namespace httplib {
class Server;
}

namespace explore::report {

inline constexpr const char* loopback = "127.0.0.1";

// Binds the server to this port (0: any that is free) of 127.0.0.1 and no other interface. Returns the port. Throws
// pave::Error for one that is taken.
int bind_to_loopback(httplib::Server& server, int wanted_port);
// Answers until the program is interrupted. ready: called once the server is reachable.
void listen_until_interrupted(httplib::Server& server, const std::function<void()>& ready);

} // namespace explore::report
