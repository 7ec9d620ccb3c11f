// Runs another program to its end.
#pragma once

#include <string>
#include <vector>

namespace explore::external {

struct ChildEnd {
    enum class Kind { exited, killed, over_time, not_started } kind = Kind::exited;
    int code = 0;       // exit status, or number of the signal
    std::string reason; // of one that was not started
};

// Runs it in this folder, without a shell, standard input empty, standard output and error into stdout.txt and
// stderr.txt there. time_limit: s, 0: none; then it is killed with all that it started.
ChildEnd run_child(const std::vector<std::string>& command, const std::string& folder, double time_limit);

} // namespace explore::external
