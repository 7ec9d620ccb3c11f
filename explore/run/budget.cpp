#include "run/budget.h"

#include "run/interrupt.h"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace explore::run {

struct Budget::Timer {
    std::mutex mutex;
    std::condition_variable condition;
    bool is_called_off = false;
    std::atomic<bool> is_spent{false};
    std::thread thread;

    void wait(double seconds) {
        std::unique_lock lock(mutex);
        if (!condition.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return is_called_off; })) {
            is_spent = true;
            request_interrupt();
        }
    }
};

Budget::Budget(double seconds) : seconds_(seconds) {
    if (seconds > 0.0) {
        timer_ = std::make_unique<Timer>();
        timer_->thread = std::thread([this] { timer_->wait(seconds_); });
    }
}

Budget::~Budget() {
    if (timer_) {
        {
            const std::scoped_lock lock(timer_->mutex);
            timer_->is_called_off = true;
        }
        timer_->condition.notify_all();
        timer_->thread.join();
    }
}

bool Budget::is_spent() const {
    return timer_ && timer_->is_spent;
}

std::optional<double> budget_of(std::string_view text) {
    double value = 0.0;
    const char* end = text.data() + text.size();
    const auto read = std::from_chars(text.data(), end, value);
    if (read.ec != std::errc()) {
        return std::nullopt;
    }
    std::string_view unit(read.ptr, static_cast<std::size_t>(end - read.ptr));
    unit.remove_prefix(std::min(unit.find_first_not_of(' '), unit.size()));
    const double seconds = unit == "s" ? 1.0 : unit == "min" ? 60.0 : unit == "h" ? 3600.0 : 0.0;
    const double budget = value * seconds;
    return budget >= least_budget && budget <= most_budget ? std::optional(budget) : std::nullopt;
}

} // namespace explore::run
