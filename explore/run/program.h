// Another program, run to its end.
#pragma once

#include <string>
#include <vector>

namespace explore::run {

struct ProgramEnd {
    bool found = true;  // on the path of programs
    int status = 0;     // exit status; 128 + its number: ended by a signal
    std::string output; // what it wrote to standard output and standard error
};

// No shell: words are its arguments as they are. Throws std::runtime_error where no process can be made.
ProgramEnd run_program(const std::vector<std::string>& words);

} // namespace explore::run
