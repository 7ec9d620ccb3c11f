// Programs, run to their end.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace explore::run {

struct ProgramEnd {
    bool found = true;  // on the path of programs
    int status = 0;     // exit status; 128 + its number: ended by a signal
    std::string output; // what it wrote to standard output and standard error
};

// No shell: words are its arguments as they are. Throws std::runtime_error where no process can be made.
ProgramEnd run_program(const std::vector<std::string>& words);

// This program, started in another folder; what it prints on standard output goes nowhere. Its exit status; nothing:
// ended by a signal, or by us at an interrupt. Throws std::runtime_error where it cannot be started from there.
std::optional<int> run_this_program(const std::vector<std::string>& arguments, const std::string& directory);

// A word of a command as a shell takes it: in quotes where it holds more than letters, digits and the signs of paths.
std::string shell_word(std::string_view text);

} // namespace explore::run
