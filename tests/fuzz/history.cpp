// How a load acted over time.
#include "data/history.h"
#include "target.h"

#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::expect_message([&] {
        const auto history = explore::data::history_of(fuzz::text_of(data, size), "/dev/shm/history.csv");
        // What a load relies on.
        bool is_right = history.time_ms.size() >= 2 && history.time_ms.size() == history.values.size();
        for (std::size_t i = 1; i < history.time_ms.size(); ++i) {
            is_right = is_right && history.time_ms[i] > history.time_ms[i - 1];
        }
        bool acts = false;
        for (const double value : history.values) {
            acts = acts || value > 0.0;
        }
        if (!is_right || !acts) {
            std::abort();
        }
    });
    return 0;
}
