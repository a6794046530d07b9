#pragma once
#include <cstdint>

namespace wick {

/// Bits that look random and depend only on the arguments (splitmix64 finaliser): the same at any thread
/// count, in any order of calls, and after a restart.
inline std::uint64_t hash_index(std::uint64_t seed, std::uint64_t index) {
  std::uint64_t z = seed * 0x9e3779b97f4a7c15ULL + (index + 1) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/// Uniform in [0, 1).
inline double hash_unit(std::uint64_t seed, std::uint64_t index) {
  return static_cast<double>(hash_index(seed, index) >> 11) * 0x1.0p-53;
}

/// Uniform in [-1, 1).
inline double hash_signed(std::uint64_t seed, std::uint64_t index) {
  return 2.0 * hash_unit(seed, index) - 1.0;
}

}  // namespace wick
