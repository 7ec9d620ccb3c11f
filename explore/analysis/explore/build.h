// The sources and settings that this program was built from.
#pragma once

#include <string>

namespace explore::analysis {

inline constexpr const char* version = PAVESCAPE_VERSION;
// The libraries on which the digits of results depend, with their versions, and the compiler.
std::string library_words();
// All of it: processes of one job compare it.
std::string build_words();

} // namespace explore::analysis
