// The terminal, if any, that a stream of this process goes to.
#pragma once

#include <cstddef>

namespace explore::cli {

bool is_terminal(int file);
// Its width, from 40 to 100; 80 where there is none.
std::size_t columns_of(int file);

} // namespace explore::cli
