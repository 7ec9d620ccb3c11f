// The hash that tells contents apart: XXH3, 128 bits, as 32 hexadecimal digits.
#pragma once

#include <string>
#include <string_view>

namespace explore::data {

std::string hash_of(std::string_view bytes);

} // namespace explore::data
