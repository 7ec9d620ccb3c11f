// A run that its limit of time ended: the one failure that another attempt may not have. Its words go with it through
// loads, processes and reports, and are what tells it.
#pragma once

#include <string_view>

namespace pave {

inline constexpr std::string_view over_time_words = "the run took longer than [solver] time_limit_s allows";

inline bool is_over_time(std::string_view reason) {
    return reason.find(over_time_words) != std::string_view::npos;
}

} // namespace pave
