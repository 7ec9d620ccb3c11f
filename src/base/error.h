// Errors that the user can fix: wrong input, met with one message that says where, what was found and what is allowed.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace pave {

// Where in the user's input a complaint belongs. Empty parts are left out of the message.
struct Place {
    std::string file{};
    int line = 0; // 1-based, 0 = unknown
    std::string key{};
};

// Thrown for input that the user can correct (exit status 2 of the program). Never thrown for a computation that
// has no answer: that is an Outcome with a reason.
class Error : public std::runtime_error {
public:
    // found: what stands there; allowed: what may stand there. Either may be empty.
    Error(const Place& place, std::string_view problem, std::string_view found = {}, std::string_view allowed = {});

private:
    static std::string message(const Place& place, std::string_view problem, std::string_view found,
                               std::string_view allowed);
};

// The member of `names` nearest to `word` (edit distance), or "" when none is near enough to be meant.
std::string nearest_name(std::string_view word, const std::vector<std::string>& names);

// "a, b, c"
std::string join(const std::vector<std::string>& names, std::string_view separator = ", ");

} // namespace pave
