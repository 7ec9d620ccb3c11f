#include "run/interrupt.h"

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <string_view>
#include <unistd.h>

namespace explore::run {
namespace {

std::atomic<bool> flag{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void say(std::string_view words) {
    [[maybe_unused]] const auto written = write(STDERR_FILENO, words.data(), words.size());
}

void give_up(int) {
    say("interrupted: what was running is lost, what was finished is kept\n");
    std::_Exit(130);
}

void handle(int number) {
    if (flag.exchange(true)) {
        std::_Exit(130);
    }
    if (number == SIGINT) {
        say("\nwaiting for the evaluations that are running; a second Ctrl-C ends at once\n");
    } else { // nobody sits there; who sent it kills after a while
        say("\nwaiting for the evaluations that are running, five seconds at most\n");
        alarm(5);
    }
}

void end(int) {
    say("interrupted\n");
    std::_Exit(130);
}

void at_interrupts(void (*handler)(int)) {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        struct sigaction before {};
        sigaction(signal, nullptr, &before);
        if (signal == SIGHUP && before.sa_handler == SIG_IGN) {
            continue;
        }
        struct sigaction action {};
        action.sa_handler = handler;
        sigaction(signal, &action, nullptr);
    }
}

} // namespace

void catch_interrupts() {
    at_interrupts(handle);
    std::signal(SIGALRM, give_up);
}

void end_at_interrupts() {
    at_interrupts(end);
}

bool interrupted() {
    return flag.load(std::memory_order_relaxed);
}

void request_interrupt() {
    flag = true;
}

void forget_interrupt() {
    flag = false;
}

} // namespace explore::run
