#include "run/interrupt.h"

#include <atomic>
#include <csignal>
#include <cstdlib>

namespace explore::run {
namespace {

std::atomic<bool> flag{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void handle(int) {
    if (flag.exchange(true)) {
        std::_Exit(130);
    }
}

} // namespace

void catch_interrupts() {
    struct sigaction action {};
    action.sa_handler = handle;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

bool interrupted() {
    return flag.load(std::memory_order_relaxed);
}

} // namespace explore::run
