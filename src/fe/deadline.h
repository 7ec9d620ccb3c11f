// When a run has to be over.
#pragma once

#include "base/outcome.h"

#include <chrono>

namespace pave::fe {

class Deadline {
public:
    using Clock = std::chrono::steady_clock;

    explicit Deadline(double seconds) : seconds_(seconds), start_(Clock::now()) {} // infinity: never

    bool has_passed() const { return std::chrono::duration<double>(Clock::now() - start_).count() > seconds_; }
    static Failure failure() { return {Status::failed, "the run took longer than [solver] time_limit_s allows"}; }

private:
    double seconds_;
    Clock::time_point start_;
};

} // namespace pave::fe
