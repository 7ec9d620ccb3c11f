#include "data/hash.h"

#include <fmt/format.h>
#include <xxhash.h>

namespace explore::data {

std::string hash_of(std::string_view bytes) {
    const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

} // namespace explore::data
