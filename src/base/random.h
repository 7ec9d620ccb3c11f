// Random numbers by counter: the k-th number of a stream is a pure function of (seed, stream, k), so any thread may
// ask for any number in any order and get the same bits.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace pave {

class RandomStream {
public:
    RandomStream(std::uint64_t seed, std::uint64_t stream) : key_(mix(mix(seed) ^ (stream * 0xd1342543de82ef95ULL))) {}

    // Uniform in (0, 1), 53 bits.
    double uniform(std::uint64_t k) const {
        return (static_cast<double>(mix(key_ + k * 0x9e3779b97f4a7c15ULL) >> 11U) + 0.5) * 0x1p-53;
    }

    // Standard normal (Box-Muller on the numbers 2k and 2k+1).
    double normal(std::uint64_t k) const {
        return std::sqrt(-2.0 * std::log(uniform(2 * k))) * std::cos(2.0 * std::numbers::pi * uniform(2 * k + 1));
    }

private:
    // The finaliser of SplitMix64 (Steele, Lea, Flood 2014).
    static std::uint64_t mix(std::uint64_t x) {
        x += 0x9e3779b97f4a7c15ULL;
        x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
        x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
        return x ^ (x >> 31U);
    }

    std::uint64_t key_;
};

} // namespace pave
