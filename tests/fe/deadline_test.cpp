// A limit of time counts what the processor did for the run, not what went by.
#include "fe/deadline.h"

#include <chrono>
#include <gtest/gtest.h>
#include <thread>

using pave::fe::Deadline;

TEST(Deadline, DoesNotPassWhileTheThreadWaits) {
    const Deadline deadline(0.05);
    std::this_thread::sleep_for(std::chrono::milliseconds(120));
    EXPECT_FALSE(deadline.has_passed());
    volatile double sum = 0.0;
    for (int i = 0; i < 2'000'000'000 && !deadline.has_passed(); ++i) {
        sum = sum + 1.0;
    }
    EXPECT_TRUE(deadline.has_passed());
    EXPECT_TRUE(pave::is_over_time("load \"fwd\": " + Deadline::failure().reason));
}
