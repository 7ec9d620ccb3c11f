// Signs of Windows-1252 besides ISO 8859-1: letters and signs where the latter has controls that no text holds.
#pragma once

#include <string_view>

namespace pave {

// Whether this character, in UTF-8, is one of them.
bool is_of_windows_1252(std::string_view character);

} // namespace pave
