// A failure of the surroundings of a run, not of its parameters: a server that is down, a disk that is full, a program
// over its limit of time. Another attempt may have an answer, so none is kept. Its words go with it through processes
// and reports, and are what tells it.
#pragma once

#include <string_view>

namespace pave {

inline constexpr std::string_view passing_words = "another attempt may have an answer";

inline bool is_passing(std::string_view reason) {
    return reason.find(passing_words) != std::string_view::npos;
}

} // namespace pave
