// When a run has to be over: by processor time of its thread, so that neither other work on the machine nor a pause of
// the process counts.
#pragma once

#include "base/outcome.h"
#include "base/over_time.h"

#include <ctime>

namespace pave::fe {

class Deadline {
public:
    explicit Deadline(double seconds) : seconds_(seconds), start_(now()) {} // infinity: never

    // On the thread that made it.
    bool has_passed() const { return now() - start_ > seconds_; }
    static Failure failure() { return {Status::failed, std::string(over_time_words)}; }

private:
    static double now() {
        timespec t{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
        return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
    }

    double seconds_;
    double start_;
};

} // namespace pave::fe
