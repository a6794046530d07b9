#pragma once
/// The words every room shares: vectors, small matrices, grid index triples. SI units throughout.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

namespace wick {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat2 = Eigen::Matrix2d;
using Mat3 = Eigen::Matrix3d;
using Mat32 = Eigen::Matrix<double, 3, 2>;
using Int2 = std::array<int, 2>;
using Int3 = std::array<int, 3>;

}  // namespace wick
