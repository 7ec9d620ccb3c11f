// Sentences of an answer.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace explore::analysis {

// Adds the sentence; "": there is nothing to say.
inline void say(std::vector<std::string>& text, std::string words) {
    if (!words.empty()) {
        text.push_back(std::move(words));
    }
}

} // namespace explore::analysis
