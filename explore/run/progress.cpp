#include "run/progress.h"

#include "run/message.h"

#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <unistd.h>

namespace explore::run {

std::string duration_words(double seconds) {
    if (seconds < 59.5) {
        return fmt::format("{:.{}f} s", seconds, seconds < 9.95 ? 1 : 0);
    }
    const long whole = std::lround(seconds);
    return whole < 3600 ? fmt::format("{} min {:02} s", whole / 60, whole % 60)
                        : fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

Progress::Progress(std::string what, std::int64_t total, ProgressRate rate)
    : what_(std::move(what)),
      total_(total),
      rate_(std::move(rate)),
      visible_(total >= 0 && isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()) {}

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

void Progress::draw(bool last) {
    using namespace std::chrono;
    const auto now = steady_clock::now();
    if (!visible_ || (!last && now - drawn_ < milliseconds(200))) {
        return;
    }
    drawn_ = now;
    const double seconds = duration<double>(now - start_).count();
    const double rate = seconds > 0.0 ? static_cast<double>(computed_) / seconds : 0.0;
    std::string line = fmt::format("\r{:<10}", what_);
    if (total_ > 0) {
        const int filled = static_cast<int>(24 * done_ / total_);
        line += fmt::format("[{:#<{}}{:.<{}}] {}/{}", "", filled, "", 24 - filled, done_, total_);
    } else {
        line += fmt::format("{}", done_);
    }
    line += fmt::format("  {:.1f} {}", rate * rate_.seconds, rate_.unit);
    if (last) {
        line += ", " + duration_words(seconds);
    } else if (total_ > 0 && rate > 0.0) {
        line += ", " + duration_words(static_cast<double>(total_ - done_) / rate) + " left";
    }
    if (!note_.empty()) {
        line += "  " + note_;
    }
    message("{}\x1b[K{}", line, last ? "\n" : "");
    std::fflush(stderr);
}

} // namespace explore::run
