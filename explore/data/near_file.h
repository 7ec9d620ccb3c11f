// A mistyped path: which file or folder was meant?
#pragma once

#include <string>

namespace explore::data {

// Behind a complaint that there is no `path`: the entry of its folder whose name is nearest (base/error.h), as
// ", did you mean \"grids/road.toml\"?"; "": none is near, or there is no such folder.
std::string near_file_words(const std::string& path);

} // namespace explore::data
