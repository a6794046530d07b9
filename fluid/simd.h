#pragma once
/// Eight floats at a time, in the compiler's own vector types: the same source runs on any machine, and where
/// the machine has AVX2 one value is one register.
#include <array>
#include <cstdint>
#include <cstring>

// Everything here is inlined, so how a vector would be passed in a call never matters.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace wick::fluid {

constexpr int lanes = 8;
using F8 = float __attribute__((vector_size(32)));
using I8 = std::int32_t __attribute__((vector_size(32)));
using D4 = double __attribute__((vector_size(32)));

#define WICK_INLINE inline __attribute__((always_inline))

WICK_INLINE F8 splat(float v) {
  return F8{v, v, v, v, v, v, v, v};
}
WICK_INLINE I8 splat(std::int32_t v) {
  return I8{v, v, v, v, v, v, v, v};
}
WICK_INLINE F8 lane_index() {
  return F8{0, 1, 2, 3, 4, 5, 6, 7};
}

WICK_INLINE F8 load8(const float* p) {
  F8 v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
WICK_INLINE void store8(float* p, F8 v) {
  std::memcpy(p, &v, sizeof v);
}
/// The lanes as an array. Code that picks a lane by a variable goes through this and never writes v[lane]: with
/// -fsanitize=undefined GCC 12 checks such an index in a register that it has already reused.
WICK_INLINE std::array<float, lanes> lanes_of(F8 v) {
  std::array<float, lanes> a;
  std::memcpy(a.data(), &v, sizeof v);
  return a;
}
WICK_INLINE std::array<std::int32_t, lanes> lanes_of(I8 v) {
  std::array<std::int32_t, lanes> a;
  std::memcpy(a.data(), &v, sizeof v);
  return a;
}
/// Stores the first `count` lanes (all of them if there are more).
WICK_INLINE void store_some(float* p, F8 v, int count) {
  if (count >= lanes) return store8(p, v);
  std::memcpy(p, &v, sizeof(float) * static_cast<std::size_t>(count));
}

WICK_INLINE F8 min8(F8 a, F8 b) {
  return a < b ? a : b;
}
WICK_INLINE F8 max8(F8 a, F8 b) {
  return a > b ? a : b;
}
WICK_INLINE I8 min8(I8 a, I8 b) {
  return a < b ? a : b;
}
WICK_INLINE F8 abs8(F8 a) {
  return max8(a, -a);
}
/// A value that is not a number becomes `low`, so that an index made of the result is always inside.
WICK_INLINE F8 clamp8(F8 x, float low, float high) {
  return min8(max8(x, splat(low)), splat(high));
}

/// Eight bytes as floats.
WICK_INLINE F8 load_bytes(const std::uint8_t* p) {
  std::uint8_t __attribute__((vector_size(8))) bytes;
  std::memcpy(&bytes, p, sizeof bytes);
  return __builtin_convertvector(__builtin_convertvector(bytes, I8), F8);
}

/// Greatest whole number not above x, for |x| < 2³¹.
WICK_INLINE F8 floor8(F8 x) {
  const F8 t = __builtin_convertvector(__builtin_convertvector(x, I8), F8);
  return t > x ? t - 1.0F : t;
}

/// Reads the pairs p[index], p[index + 1]: one 8-byte load a lane instead of two gathers of four bytes.
WICK_INLINE void load_pairs(const float* p, const std::int32_t* index, F8& first, F8& second) {
  const auto pair = [&](int lane) {
    double bits;
    std::memcpy(&bits, p + index[lane], sizeof bits);
    return bits;
  };
  const D4 a = {pair(0), pair(1), pair(4), pair(5)};
  const D4 b = {pair(2), pair(3), pair(6), pair(7)};
  F8 fa, fb;
  std::memcpy(&fa, &a, sizeof a);
  std::memcpy(&fb, &b, sizeof b);
  first = __builtin_shufflevector(fa, fb, 0, 2, 8, 10, 4, 6, 12, 14);
  second = __builtin_shufflevector(fa, fb, 1, 3, 9, 11, 5, 7, 13, 15);
}

}  // namespace wick::fluid

#pragma GCC diagnostic pop
