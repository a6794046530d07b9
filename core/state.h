#pragma once
/// How state is walked: one `visit(StateVisitor&, State&)` per State struct names each field once.
/// Checkpoint writing, checkpoint reading and the state hash are three visitors over the same walk.
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/function_ref.h"
#include "core/types.h"

namespace wick {

enum class ScalarType { f32, f64, i32, i64, u8, u64 };

template <class T>
constexpr ScalarType scalar_type() {
  if constexpr (std::is_same_v<T, float>)
    return ScalarType::f32;
  else if constexpr (std::is_same_v<T, double>)
    return ScalarType::f64;
  else if constexpr (std::is_same_v<T, std::int32_t>)
    return ScalarType::i32;
  else if constexpr (std::is_same_v<T, std::int64_t>)
    return ScalarType::i64;
  else if constexpr (std::is_same_v<T, std::uint64_t>)
    return ScalarType::u64;
  else {
    static_assert(std::is_same_v<T, std::uint8_t>, "a type that a checkpoint can hold");
    return ScalarType::u8;
  }
}

class StateVisitor {
 public:
  virtual ~StateVisitor() = default;

  /// One array of `rows` x `columns` scalars at `data`. A reader calls resize(rows) first and fills the
  /// storage that it returns; every other visitor only looks at `data`.
  virtual void raw(std::string_view name, ScalarType type, std::size_t rows, std::size_t columns, const void* data,
                   FunctionRef<void*(std::size_t rows)> resize) = 0;
  virtual void strings(std::string_view name, std::vector<std::string>& values) = 0;
  virtual void begin_group(std::string_view name) = 0;
  virtual void end_group() = 0;

  template <class Body>
  void group(std::string_view name, Body&& body) {
    begin_group(name);
    body();
    end_group();
  }
  template <class T>
  requires std::is_arithmetic_v<T>
  void array(std::string_view name, std::vector<T>& values) {
    raw(name, scalar_type<T>(), values.size(), 1, values.data(), [&](std::size_t rows) -> void* {
      values.resize(rows);
      return values.data();
    });
  }
  template <class T, int N>
  void array(std::string_view name, std::vector<Eigen::Matrix<T, N, 1>>& values) {
    raw(name, scalar_type<T>(), values.size(), N, values.data(), [&](std::size_t rows) -> void* {
      values.resize(rows);
      return values.data();
    });
  }
  template <class T, std::size_t N>
  void array(std::string_view name, std::vector<std::array<T, N>>& values) {
    raw(name, scalar_type<T>(), values.size(), N, values.data(), [&](std::size_t rows) -> void* {
      values.resize(rows);
      return values.data();
    });
  }
  void array(std::string_view name, std::vector<std::string>& values) { strings(name, values); }

  /// A single scalar, or a small fixed vector.
  template <class T>
  requires std::is_arithmetic_v<T>
  void value(std::string_view name, T& v) {
    raw(name, scalar_type<T>(), 1, 1, &v, [&](std::size_t) -> void* { return &v; });
  }
  void value(std::string_view name, bool& v) {
    std::uint8_t byte = v ? 1 : 0;
    value(name, byte);
    v = byte != 0;
  }
  template <class T, int N>
  void value(std::string_view name, Eigen::Matrix<T, N, 1>& v) {
    raw(name, scalar_type<T>(), 1, N, v.data(), [&](std::size_t) -> void* { return v.data(); });
  }
};

/// 64-bit hash of a state: names, shapes and the bits of every value, in the order of the walk.
class StateHash final : public StateVisitor {
 public:
  void raw(std::string_view name, ScalarType type, std::size_t rows, std::size_t columns, const void* data,
           FunctionRef<void*(std::size_t)> resize) override;
  void strings(std::string_view name, std::vector<std::string>& values) override;
  void begin_group(std::string_view name) override;
  void end_group() override;
  [[nodiscard]] std::uint64_t digest() const { return hash_; }

 private:
  void mix(const void* bytes, std::size_t size);
  std::uint64_t hash_ = 0x9e3779b97f4a7c15ULL;
};

std::size_t scalar_size(ScalarType type);

/// 64-bit hash of a run of bytes (used for file checksums as well as for the state hash).
std::uint64_t hash_bytes(const void* bytes, std::size_t size, std::uint64_t seed = 0);

}  // namespace wick
