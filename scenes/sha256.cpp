#include "scenes/sha256.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

namespace wick::scenes {

namespace {

using Word = std::uint32_t;
using Wide = unsigned __int128;

/// The first 32 bits behind the point of the square root (power 2) or cube root (power 3) of a prime: the largest
/// x with x^power <= prime * 2^(32 power), without its whole part.
constexpr Word root_bits(int prime, int power) {
  const Wide target = static_cast<Wide>(prime) << (32 * power);
  Wide root = 0;
  for (int bit = 36; bit >= 0; --bit) {
    const Wide tried = root | static_cast<Wide>(1) << bit;
    if ((power == 2 ? tried * tried : tried * tried * tried) <= target) root = tried;
  }
  return static_cast<Word>(root);
}

template <std::size_t count>
constexpr std::array<Word, count> roots_of_primes(int power) {
  std::array<Word, count> roots{};
  int prime = 1;
  for (Word& root : roots) {
    for (bool divides = true; divides;) {
      ++prime;
      divides = false;
      for (int d = 2; d * d <= prime; ++d) divides = divides || prime % d == 0;
    }
    root = root_bits(prime, power);
  }
  return roots;
}

constexpr auto start = roots_of_primes<8>(2);       // H(0), section 5.3.3
constexpr auto constants = roots_of_primes<64>(3);  // K, section 4.2.2

/// Section 6.2.2: one block of 64 bytes.
void digest_block(std::array<Word, 8>& state, const char* block) {
  std::array<Word, 64> w;
  for (int t = 0; t < 16; ++t) {
    const auto* b = reinterpret_cast<const unsigned char*>(block + 4 * t);
    w[t] = Word{b[0]} << 24 | Word{b[1]} << 16 | Word{b[2]} << 8 | Word{b[3]};
  }
  for (int t = 16; t < 64; ++t) {
    const Word s0 = std::rotr(w[t - 15], 7) ^ std::rotr(w[t - 15], 18) ^ w[t - 15] >> 3;
    const Word s1 = std::rotr(w[t - 2], 17) ^ std::rotr(w[t - 2], 19) ^ w[t - 2] >> 10;
    w[t] = w[t - 16] + s0 + w[t - 7] + s1;
  }
  auto [a, b, c, d, e, f, g, h] = state;
  for (int t = 0; t < 64; ++t) {
    const Word s1 = std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25);
    const Word t1 = h + s1 + ((e & f) ^ (~e & g)) + constants[t] + w[t];
    const Word s0 = std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22);
    const Word t2 = s0 + ((a & b) ^ (a & c) ^ (b & c));
    h = g, g = f, f = e, e = d + t1, d = c, c = b, b = a, a = t1 + t2;
  }
  const std::array<Word, 8> mixed{a, b, c, d, e, f, g, h};
  for (int i = 0; i < 8; ++i) state[i] += mixed[i];
}

}  // namespace

std::string sha256(std::string_view bytes) {
  std::array<Word, 8> state = start;
  const std::uint64_t bits = 8 * static_cast<std::uint64_t>(bytes.size());
  for (; bytes.size() >= 64; bytes.remove_prefix(64)) digest_block(state, bytes.data());
  // Section 5.1.1: a one, zeros up to 8 bytes before the end of a block, and the length in bits.
  std::string tail(bytes);
  tail += '\x80';
  tail.resize((tail.size() + 8 + 63) / 64 * 64, '\0');
  for (int i = 0; i < 8; ++i) tail[tail.size() - 1 - i] = static_cast<char>(bits >> (8 * i));
  for (std::size_t at = 0; at < tail.size(); at += 64) digest_block(state, tail.data() + at);
  std::string text;
  for (const Word word : state) text += fmt::format("{:08x}", word);
  return text;
}

}  // namespace wick::scenes
