#include "external/child.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

extern char** environ;

namespace explore::external {

ChildEnd run_child(const std::vector<std::string>& command, const std::string& folder, double time_limit) {
    using Clock = std::chrono::steady_clock;
    std::vector<char*> arguments;
    for (const std::string& word : command) {
        arguments.push_back(const_cast<char*>(word.c_str()));
    }
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "stdout.txt", O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "stderr.txt", O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t none, usual;
    sigemptyset(&none);
    sigemptyset(&usual);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) {
        sigaddset(&usual, signal);
    }
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &usual);
    posix_spawnattr_setpgroup(&attributes, 0); // of its own: Ctrl-C lets it finish, and all of it can be killed
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    pid_t child = 0;
    const int error = posix_spawnp(&child, arguments[0], &actions, &attributes, arguments.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) {
        return {ChildEnd::Kind::not_started, error, std::strerror(error)};
    }
    const auto begin = Clock::now();
    for (;;) {
        int status = 0;
        const pid_t ended = waitpid(child, &status, WNOHANG);
        if (ended == child) {
            kill(-child, SIGKILL); // what it left running
            return WIFSIGNALED(status) ? ChildEnd{ChildEnd::Kind::killed, WTERMSIG(status), {}}
                                       : ChildEnd{ChildEnd::Kind::exited, WEXITSTATUS(status), {}};
        }
        const std::chrono::duration<double> passed = Clock::now() - begin;
        if (time_limit > 0.0 && passed.count() > time_limit) {
            kill(-child, SIGKILL);
            waitpid(child, &status, 0);
            return {ChildEnd::Kind::over_time, 0, {}};
        }
        // A twentieth of its time: 5 ms at most.
        std::this_thread::sleep_for(std::chrono::duration<double>(std::clamp(0.05 * passed.count(), 2e-4, 5e-3)));
    }
}

} // namespace explore::external
