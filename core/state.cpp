#include "core/state.h"

#include <bit>
#include <cstring>

namespace wick {

std::size_t scalar_size(ScalarType type) {
  switch (type) {
    case ScalarType::u8:
      return 1;
    case ScalarType::f32:
    case ScalarType::i32:
      return 4;
    case ScalarType::f64:
    case ScalarType::i64:
    case ScalarType::u64:
      return 8;
  }
  return 0;
}

std::uint64_t hash_bytes(const void* bytes, std::size_t size, std::uint64_t seed) {
  // Multiply and rotate over 8-byte words, four lanes at a time so that the multiplier's latency is
  // hidden; then the finaliser of splitmix64. Constants are odd and otherwise arbitrary.
  constexpr std::uint64_t k1 = 0x9fb21c651e98df25ULL, k2 = 0xd6e8feb86659fd93ULL;
  const auto* p = static_cast<const unsigned char*>(bytes);
  std::uint64_t lane[4] = {seed ^ k1, seed + k2, seed ^ ~k1, seed - k2};
  const auto absorb = [&](std::uint64_t& state, const unsigned char* at) {
    std::uint64_t word;
    std::memcpy(&word, at, 8);
    state = std::rotl((state ^ word) * k1, 29) * k2;
  };
  std::size_t left = size;
  for (; left >= 32; left -= 32, p += 32)
    for (int i = 0; i < 4; ++i) absorb(lane[i], p + 8 * i);
  for (; left >= 8; left -= 8, p += 8) absorb(lane[0], p);
  std::uint64_t tail = 0;
  if (left > 0) std::memcpy(&tail, p, left);  // an empty field has no address
  std::uint64_t h = lane[0] ^ std::rotl(lane[1], 17) ^ std::rotl(lane[2], 31) ^ std::rotl(lane[3], 47);
  h ^= tail * k1 + size;
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
  return h ^ (h >> 31);
}

void StateHash::mix(const void* bytes, std::size_t size) {
  hash_ = hash_bytes(bytes, size, hash_);
}

void StateHash::raw(std::string_view name, ScalarType type, std::size_t rows, std::size_t columns, const void* data,
                    FunctionRef<void*(std::size_t)>) {
  mix(name.data(), name.size());
  const std::uint64_t shape[3] = {static_cast<std::uint64_t>(type), rows, columns};
  mix(shape, sizeof shape);
  mix(data, rows * columns * scalar_size(type));
}

void StateHash::strings(std::string_view name, std::vector<std::string>& values) {
  mix(name.data(), name.size());
  for (const std::string& value : values) mix(value.data(), value.size());
}

void StateHash::begin_group(std::string_view name) {
  mix(name.data(), name.size());
}

void StateHash::end_group() {
  mix("/", 1);
}

}  // namespace wick
