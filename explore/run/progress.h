// A line on the terminal while long work goes on: done, rate, time left. Where standard error is no terminal, a line a
// minute.
#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>

namespace explore::run {

struct ProgressRate {
    std::string unit = "runs/s";
    double seconds = 1.0; // that it counts over
};

class Progress {
public:
    // total = 0: unknown, no bar and no time left; negative: show nothing.
    Progress(std::string what, std::int64_t total, ProgressRate rate = {});
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    // n more are done; computed: by this process just now (they make the rate), else they were known already.
    void add(std::int64_t n, bool computed);
    void note(std::string note);     // shown behind the figures
    void say(std::string_view line); // above the figures, at once

private:
    void draw(bool last);
    std::string figures(double seconds, bool last) const; // "3400/8000  12.3 runs/s, 2 min 05 s left"

    std::mutex mutex_;
    std::string what_;
    std::string note_;
    std::int64_t total_;
    ProgressRate rate_;
    std::int64_t done_ = 0;
    std::int64_t computed_ = 0;
    bool visible_;
    bool on_terminal_;
    std::chrono::steady_clock::time_point start_;
    std::chrono::steady_clock::time_point drawn_;
};

// "2 min 05 s"
std::string duration_words(double seconds);
// "35 MB", "2.1 GB"
std::string memory_words(double bytes);

} // namespace explore::run
