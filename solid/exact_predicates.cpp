#include "solid/exact_predicates.h"

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>

namespace wick::solid {

namespace {

using Integer = boost::multiprecision::cpp_int;
using Vector = std::array<Integer, 3>;

int sign_of(double value) {
  return value > 0.0 ? 1 : (value < 0.0 ? -1 : 0);
}

constexpr int kMantissa = std::numeric_limits<double>::digits;

/// Smallest exponent of the coordinates, of those that are not 0.
int least_exponent(std::initializer_list<const Vec3*> points) {
  int least = std::numeric_limits<int>::max();
  for (const Vec3* p : points)
    for (int k = 0; k < 3; ++k)
      if (int exponent = 0; (*p)[k] != 0.0) {
        std::frexp((*p)[k], &exponent);
        least = std::min(least, exponent);
      }
  return least;
}

/// The point in units of 2^(least - 53): whole numbers.
Vector scaled(const Vec3& p, int least) {
  Vector result;
  for (int k = 0; k < 3; ++k) {
    if (p[k] == 0.0) continue;
    int exponent = 0;
    const double mantissa = std::frexp(p[k], &exponent);
    result[k] = static_cast<std::int64_t>(std::ldexp(mantissa, kMantissa));
    result[k] <<= exponent - least;
  }
  return result;
}

Vector difference(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

int exact_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const int least = least_exponent({&a, &b, &c, &d});
  const Vector origin = scaled(d, least);
  const Vector u = difference(scaled(a, least), origin), v = difference(scaled(b, least), origin),
               w = difference(scaled(c, least), origin);
  const Integer volume =
      u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0]);
  return volume.sign();
}

}  // namespace

int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = a - d, v = b - d, w = c - d;
  const Vec3 size = u.cwiseAbs(), first = v.cwiseAbs(), second = w.cwiseAbs();
  const double volume = u.dot(v.cross(w));
  const double terms = size.x() * (first.y() * second.z() + first.z() * second.y()) +
                       size.y() * (first.z() * second.x() + first.x() * second.z()) +
                       size.z() * (first.x() * second.y() + first.y() * second.x());
  // Each of the six products carries at most 8 roundings, sums included [Shewchuk 1997 gives 7 + 56 eps].
  // Differences that are 0 are exact, so terms of 0 leave nothing to doubt, unless products have underflowed.
  constexpr double kRoundings = 8.0 * std::numeric_limits<double>::epsilon();
  constexpr double kTiny = 1e-280;
  if (terms > kTiny && terms < std::numeric_limits<double>::max() && std::abs(volume) > kRoundings * terms)
    return sign_of(volume);
  const bool flat = (size.x() == 0.0 && first.x() == 0.0 && second.x() == 0.0) ||
                    (size.y() == 0.0 && first.y() == 0.0 && second.y() == 0.0) ||
                    (size.z() == 0.0 && first.z() == 0.0 && second.z() == 0.0);
  return flat ? 0 : exact_orientation(a, b, c, d);
}

int orientation(const Vec3& a, const Vec3& b, const Vec3& c, int axis) {
  // The fourth point is c, lifted along the axis: the volume is the area times the lift.
  Vec3 flat_a = a, flat_b = b, flat_c = c;
  flat_a[axis] = flat_b[axis] = flat_c[axis] = 0.0;
  Vec3 above = flat_c;
  above[axis] = 1.0;
  return orientation(flat_a, flat_b, flat_c, above);
}

bool segments_meet(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b) {
  for (int k = 0; k < 3; ++k)
    if (std::max(p[k], q[k]) < std::min(a[k], b[k]) || std::max(a[k], b[k]) < std::min(p[k], q[k])) return false;
  if (orientation(p, q, a, b) != 0) return false;
  for (int axis = 0; axis < 3; ++axis) {
    const int pqa = orientation(p, q, a, axis), pqb = orientation(p, q, b, axis);
    const int abp = orientation(a, b, p, axis), abq = orientation(a, b, q, axis);
    // Where the four do not fall on one line, seeing them along the axis loses nothing of their plane.
    if (pqa != 0 || pqb != 0 || abp != 0 || abq != 0) return pqa * pqb <= 0 && abp * abq <= 0;
  }
  return true;  // on one line, with overlapping boxes
}

bool segment_meets_triangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const int side_p = orientation(a, b, c, p), side_q = orientation(a, b, c, q);
  if (side_p * side_q > 0) return false;
  if (side_p != 0 || side_q != 0) {
    const int ab = orientation(p, q, a, b), bc = orientation(p, q, b, c), ca = orientation(p, q, c, a);
    return (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
  }
  if (segments_meet(p, q, a, b) || segments_meet(p, q, b, c) || segments_meet(p, q, c, a)) return true;
  for (int axis = 0; axis < 3; ++axis) {
    if (orientation(a, b, c, axis) == 0) continue;
    const int ab = orientation(a, b, p, axis), bc = orientation(b, c, p, axis), ca = orientation(c, a, p, axis);
    return ab == bc && bc == ca;  // p inside; q cannot be elsewhere, as no rim is met
  }
  return false;
}

}  // namespace wick::solid
