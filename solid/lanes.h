#pragma once
/// Four constraints at a time: the formulas of the constraints are templates over a scalar that is either
/// double or Lanes, so that what the tests check is what runs.
#include <cstdint>
#include <cstring>

#include "core/types.h"

namespace wick::solid {

inline constexpr int kLanes = 4;
/// Four doubles that are worked on together; operators act lane by lane.
typedef double Lanes __attribute__((vector_size(32)));

/// One vertex in the solver's own arrays: a 3-vector and a scalar (the inverse mass, or nothing).
struct alignas(32) Row {
  double x, y, z, w;
};

template <class T>
struct Triple {
  T x, y, z;
};
template <class T>
Triple<T> operator+(const Triple<T>& a, const Triple<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
Triple<T> operator-(const Triple<T>& a, const Triple<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
Triple<T> operator*(const T& s, const Triple<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
T dot(const Triple<T>& a, const Triple<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
Triple<T> cross(const Triple<T>& a, const Triple<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
T larger(const T& a, const T& b) {
  return a > b ? a : b;
}
template <class T>
T smaller(const T& a, const T& b) {
  return a < b ? a : b;
}

inline Lanes square_root(Lanes a) {
  for (int k = 0; k < kLanes; ++k) a[k] = __builtin_sqrt(a[k]);
  return a;
}
inline double square_root(double a) {
  return __builtin_sqrt(a);
}
inline bool any_greater(double a, double b) {
  return a > b;
}
inline bool any_greater(const Lanes& a, const Lanes& b) {
  const auto mask = a > b;
  return (mask[0] | mask[1] | mask[2] | mask[3]) != 0;
}
template <class T>
T constant(double value) {
  return T{} + value;
}

inline Lanes load_lanes(const void* from) {
  Lanes value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

template <class T>
struct Vertex {
  Triple<T> p;
  T w;  ///< inverse mass [1/kg]
};

/// Reads the rows of four vertices and turns them into lanes of x, y, z, w.
inline Vertex<Lanes> gather(const Row* rows, const std::int32_t* index) {
  const Lanes a = load_lanes(rows + index[0]), b = load_lanes(rows + index[1]);
  const Lanes c = load_lanes(rows + index[2]), d = load_lanes(rows + index[3]);
  const Lanes ab_xz = __builtin_shufflevector(a, b, 0, 4, 2, 6), ab_yw = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Lanes cd_xz = __builtin_shufflevector(c, d, 0, 4, 2, 6), cd_yw = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  return {{__builtin_shufflevector(ab_xz, cd_xz, 0, 1, 4, 5), __builtin_shufflevector(ab_yw, cd_yw, 0, 1, 4, 5),
           __builtin_shufflevector(ab_xz, cd_xz, 2, 3, 6, 7)},
          __builtin_shufflevector(ab_yw, cd_yw, 2, 3, 6, 7)};
}

/// The reverse of gather.
inline void scatter(Row* rows, const std::int32_t* index, const Vertex<Lanes>& v) {
  const Lanes ab_xz = __builtin_shufflevector(v.p.x, v.p.z, 0, 4, 2, 6);
  const Lanes cd_xz = __builtin_shufflevector(v.p.x, v.p.z, 1, 5, 3, 7);
  const Lanes ab_yw = __builtin_shufflevector(v.p.y, v.w, 0, 4, 2, 6);
  const Lanes cd_yw = __builtin_shufflevector(v.p.y, v.w, 1, 5, 3, 7);
  const Lanes row[4] = {
      __builtin_shufflevector(ab_xz, ab_yw, 0, 4, 1, 5), __builtin_shufflevector(cd_xz, cd_yw, 0, 4, 1, 5),
      __builtin_shufflevector(ab_xz, ab_yw, 2, 6, 3, 7), __builtin_shufflevector(cd_xz, cd_yw, 2, 6, 3, 7)};
  for (int k = 0; k < kLanes; ++k) std::memcpy(rows + index[k], &row[k], sizeof(Row));
}

}  // namespace wick::solid
