// Reads the table [solver] of a study.
#pragma once

#include "study/study.h"

#include <toml++/toml.h>

namespace explore::study {

// Throws pave::Error.
void read_solver(const toml::table& table, Study& study);

} // namespace explore::study
