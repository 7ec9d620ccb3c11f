// A limit of time for a whole analysis: what Ctrl-C does, by the clock.
#pragma once

#include <memory>
#include <optional>
#include <string_view>

namespace explore::run {

// From its making on so many seconds of wall time, then run::interrupted(): what is running is finished and kept, and
// the analysis gives no result. 0: no limit. All analyses of the process are ended; who goes on afterwards forgets the
// interrupt (run/interrupt.h).
class Budget {
public:
    explicit Budget(double seconds);
    ~Budget();
    Budget(const Budget&) = delete;
    Budget& operator=(const Budget&) = delete;

    double seconds() const { return seconds_; }
    bool is_spent() const;

private:
    struct Timer;
    double seconds_;
    std::unique_ptr<Timer> timer_;
};

// The range of a budget, and its forms.
inline constexpr double least_budget = 0.1, most_budget = 1e7; // s
inline constexpr std::string_view budget_words = "30s, 10min or 2h, 0.1 s to 2700 h";
// Seconds of "30s", "10min" or "2h" ("1.5h", "90 s"); nothing: no such time, or one beyond those.
std::optional<double> budget_of(std::string_view text);

} // namespace explore::run
