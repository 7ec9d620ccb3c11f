// A vector of doubles, one lane a run, and the functions the laws need of it. Private to fe/lanes/: what includes this
// is compiled once for every set of instructions, within a namespace of its own (PAVE_LANES), and takes nothing of the
// standard library that could be shared with code for another processor.
//
// Every operation is the same in every width, and multiplications are fused with additions where it is written so: a
// lane has the same bits with 128, 256 and 512 bits. Without fused instructions (SSE2) they differ in the last places.
#pragma once

#include <cstdint>
#ifdef __SSE2__
#include <immintrin.h>
#endif

#define PAVE_INLINE inline __attribute__((always_inline))

namespace pave::fe::lanes::PAVE_LANES {

// PAVE_LANES_WIDTH: 8, 4 or 2 lanes; with fewer than the instructions have, for few runs.
inline constexpr int width = PAVE_LANES_WIDTH;
#ifdef __AVX512F__
inline constexpr bool many_registers = true; // 32 of them
#else
inline constexpr bool many_registers = false; // 16
#endif

#ifdef __FMA__
inline constexpr bool is_fused = true;
#else
inline constexpr bool is_fused = false;
#endif

using Lanes = double __attribute__((vector_size(8 * width), may_alias));
using Mask = std::int64_t __attribute__((vector_size(8 * width), may_alias)); // all bits of a lane are the same
using Bits = std::uint64_t __attribute__((vector_size(8 * width), may_alias));

PAVE_INLINE Lanes all(double x) {
    return x - Lanes{}; // minus zero stays what it is
}
// a b + c, and c - a b.
PAVE_INLINE Lanes fma(Lanes a, Lanes b, Lanes c) {
#if PAVE_LANES_WIDTH == 8
    return _mm512_fmadd_pd(a, b, c);
#elif PAVE_LANES_WIDTH == 4
    return _mm256_fmadd_pd(a, b, c);
#elif defined(__FMA__)
    return _mm_fmadd_pd(a, b, c);
#else
    return a * b + c;
#endif
}
PAVE_INLINE Lanes fma(double a, Lanes b, Lanes c) {
    return fma(all(a), b, c);
}
PAVE_INLINE Lanes minus(Lanes a, Lanes b, Lanes c) {
#if PAVE_LANES_WIDTH == 8
    return _mm512_fnmadd_pd(a, b, c);
#elif PAVE_LANES_WIDTH == 4
    return _mm256_fnmadd_pd(a, b, c);
#elif defined(__FMA__)
    return _mm_fnmadd_pd(a, b, c);
#else
    return c - a * b;
#endif
}
PAVE_INLINE Lanes root(Lanes x) {
#if PAVE_LANES_WIDTH == 8
    return _mm512_maskz_sqrt_pd(static_cast<__mmask8>(-1), x); // the plain one makes g++ 12 warn falsely
#elif PAVE_LANES_WIDTH == 4
    return _mm256_sqrt_pd(x);
#elif defined(__SSE2__)
    return _mm_sqrt_pd(x);
#else
    for (int i = 0; i < width; ++i) {
        x[i] = __builtin_sqrt(x[i]);
    }
    return x;
#endif
}
PAVE_INLINE Lanes choose(Mask where, Lanes yes, Lanes no) {
    return where ? yes : no;
}

// ln x of positive normal numbers, within two units in the last place; not a number for all others. With x = 2^e m, m
// within sqrt(2) of 1, f = m - 1 and s = f/(2 + f): ln m = 2 artanh s = f - s (f - 2 (s^2/3 + s^4/5 + ...)).
PAVE_INLINE Lanes log(Lanes x) {
    constexpr std::uint64_t one = 0x3ff0000000000000U;
    constexpr std::uint64_t root_half = 0x3fe6a09e667f3bcdU;
    constexpr std::uint64_t two_52 = 0x4330000000000000U;
    const Bits bits = (Bits)x + (one - root_half);
    const Bits exponent = bits >> 52;
    const Lanes e = (Lanes)(exponent | two_52) - (4503599627370496.0 + 1023.0);
    const Lanes m = (Lanes)((bits & 0x000fffffffffffffU) + root_half);
    const Lanes f = m - 1.0;
    const Lanes s = f / (2.0 + f);
    const Lanes z = s * s;
    Lanes sum = all(2.0 / 23.0);
    sum = fma(sum, z, all(2.0 / 21.0));
    sum = fma(sum, z, all(2.0 / 19.0));
    sum = fma(sum, z, all(2.0 / 17.0));
    sum = fma(sum, z, all(2.0 / 15.0));
    sum = fma(sum, z, all(2.0 / 13.0));
    sum = fma(sum, z, all(2.0 / 11.0));
    sum = fma(sum, z, all(2.0 / 9.0));
    sum = fma(sum, z, all(2.0 / 7.0));
    sum = fma(sum, z, all(2.0 / 5.0));
    sum = fma(sum, z, all(2.0 / 3.0));
    constexpr double ln2_high = 0x1.62e42fefa3800p-1; // its last eleven bits are zero: times an exponent it is exact
    constexpr double ln2_low = 0x1.ef35793c76730p-45;
    const Lanes rest = minus(s, minus(z, sum, f), e * ln2_low);
    const Lanes value = fma(e, all(ln2_high), f) + rest;
    return choose((x >= __DBL_MIN__) & (x <= __DBL_MAX__), value, all(__builtin_nan("")));
}

// ln(1 + x) of x >= 0.
PAVE_INLINE Lanes log_1_plus(Lanes x) {
    const Lanes y = 1.0 + x;
    return log(y) + (x - (y - 1.0)) / y; // what the sum has rounded off
}

// exp x within two units in the last place; zero below -708, exp(709) above it, not a number for what is none. With x =
// n ln 2 + r: 2^n times the series of exp r.
PAVE_INLINE Lanes exp(Lanes x) {
    constexpr double highest = 709.0;
    constexpr double lowest = -708.0;
    const Lanes within = choose(x > highest, all(highest), choose(x < lowest, all(lowest), x));
    constexpr double to_integer = 6755399441055744.0; // 1.5 * 2^52: what is added to it is rounded to an integer
    const Lanes shifted = fma(within, all(1.4426950408889634074), all(to_integer));
    const Lanes n = shifted - to_integer;
    const Lanes r = minus(n, all(0x1.ef35793c76730p-45), minus(n, all(0x1.62e42fefa3800p-1), within));
    Lanes sum = all(1.0 / 6227020800.0);
    sum = fma(sum, r, all(1.0 / 479001600.0));
    sum = fma(sum, r, all(1.0 / 39916800.0));
    sum = fma(sum, r, all(1.0 / 3628800.0));
    sum = fma(sum, r, all(1.0 / 362880.0));
    sum = fma(sum, r, all(1.0 / 40320.0));
    sum = fma(sum, r, all(1.0 / 5040.0));
    sum = fma(sum, r, all(1.0 / 720.0));
    sum = fma(sum, r, all(1.0 / 120.0));
    sum = fma(sum, r, all(1.0 / 24.0));
    sum = fma(sum, r, all(1.0 / 6.0));
    sum = fma(sum, r, all(0.5));
    const Lanes of_r = 1.0 + fma(sum, r * r, r);
    const Lanes value = (Lanes)((Bits)of_r + ((Bits)shifted << 52));
    return choose(x < lowest, all(0.0), choose(x == x, value, x));
}

} // namespace pave::fe::lanes::PAVE_LANES
