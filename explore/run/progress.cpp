#include "run/progress.h"

#include "run/message.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <unistd.h>

namespace explore::run {
namespace {

using Clock = std::chrono::steady_clock;

// When this process last wrote a line where there is no terminal: its parts share one line a minute.
std::atomic<Clock::time_point>& last_line() {
    static std::atomic<Clock::time_point> at = Clock::now();
    return at;
}

// Whether a line is due; at most one caller is told so.
bool line_is_due(Clock::time_point now) {
    Clock::time_point last = last_line();
    return now - last >= std::chrono::minutes(1) && last_line().compare_exchange_strong(last, now);
}

} // namespace

std::string duration_words(double seconds) {
    if (seconds < 59.5) {
        return fmt::format("{:.{}f} s", seconds, seconds < 9.95 ? 1 : 0);
    }
    const long whole = std::lround(seconds);
    return whole < 3600 ? fmt::format("{} min {:02} s", whole / 60, whole % 60)
                        : fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

std::string memory_words(double bytes) {
    const double mega = bytes / 1e6;
    return mega < 999.5 ? fmt::format("{:.0f} MB", std::max(mega, 1.0)) : fmt::format("{:.1f} GB", mega / 1e3);
}

Progress::Progress(std::string what, std::int64_t total, ProgressRate rate)
    : what_(std::move(what)),
      total_(total),
      rate_(std::move(rate)),
      visible_(total >= 0),
      on_terminal_(isatty(STDERR_FILENO) == 1),
      start_(Clock::now()) {
    last_line();
}

Progress::~Progress() {
    draw(true);
}

void Progress::add(std::int64_t n, bool computed) {
    const std::scoped_lock lock(mutex_);
    done_ += n;
    computed_ += computed ? n : 0;
    draw(false);
}

void Progress::note(std::string note) {
    const std::scoped_lock lock(mutex_);
    note_ = std::move(note);
}

void Progress::say(std::string_view line) {
    const std::scoped_lock lock(mutex_);
    if (visible_) {
        message("{}{}: {}\n", on_terminal_ ? "\r\x1b[K" : "", what_, line);
    }
}

std::string Progress::figures(double seconds, bool last) const {
    std::string line = total_ > 0 ? fmt::format("{}/{}", done_, total_) : fmt::format("{}", done_);
    const double rate = seconds > 0.0 ? static_cast<double>(computed_) / seconds : 0.0;
    line += fmt::format("  {:.1f} {}", rate * rate_.seconds, rate_.unit);
    if (last) {
        line += ", " + duration_words(seconds);
    } else if (total_ > 0 && rate > 0.0) {
        line += ", " + duration_words(static_cast<double>(total_ - done_) / rate) + " left";
    }
    return note_.empty() ? line : line + "  " + note_;
}

void Progress::draw(bool last) {
    const auto now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - start_).count();
    if (visible_ && !on_terminal_ && !last && line_is_due(now)) {
        message("{}: {}\n", what_, figures(seconds, last));
    }
    if (!visible_ || !on_terminal_ || (!last && now - drawn_ < std::chrono::milliseconds(200))) {
        return;
    }
    drawn_ = now;
    std::string bar;
    if (total_ > 0) {
        const int filled = static_cast<int>(24 * done_ / total_);
        bar = fmt::format("[{:#<{}}{:.<{}}] ", "", filled, "", 24 - filled);
    }
    message("\r{:<10}{}{}\x1b[K{}", what_, bar, figures(seconds, last), last ? "\n" : "");
    std::fflush(stderr);
}

} // namespace explore::run
