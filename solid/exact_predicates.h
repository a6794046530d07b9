#pragma once
/// Signs of determinants of points, exact for any finite doubles: whether a segment meets a triangle is then a
/// fact, not a matter of rounding.
#include "core/types.h"

namespace wick::solid {

/// Sign of the volume of the tetrahedron a, b, c, d (6 V = (a - d) . (b - d) x (c - d)): 1, -1, or 0 when the four
/// points lie in one plane.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Sign of the area of the triangle a, b, c seen along `axis` (0, 1, 2): 0 when the three lie on one line there.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, int axis);

/// Whether the segments p-q and a-b share a point, their ends included; either may be a single point.
bool segments_meet(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b);

/// Whether the segment p-q and the triangle a, b, c share a point, ends and rims included. The triangle may be a
/// line or a point, and the segment may lie in its plane.
bool segment_meets_triangle(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace wick::solid
