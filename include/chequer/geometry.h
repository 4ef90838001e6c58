#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>

#pragma GCC visibility push(default)  // part of libchequer's interface

namespace chequer {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// An array of zero vectors. Eigen leaves its vectors as the memory was, also in `std::array<Eigen::Vector2f, 4> a{};`.
template <typename Vector, std::size_t kCount>
std::array<Vector, kCount> Zeros() {
  std::array<Vector, kCount> zeros;
  zeros.fill(Vector::Zero());
  return zeros;
}

/// A rigid transform, named target_from_source: x_in_target = rotation · x_in_source + translation. Metres.
struct RigidTransform {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& x_in_source) const { return rotation * x_in_source + translation; }
  /// c_from_b * b_from_a = c_from_a.
  RigidTransform operator*(const RigidTransform& other) const {
    return {(rotation * other.rotation).normalized(), rotation * other.translation + translation};
  }
  /// source_from_target.
  RigidTransform Inverse() const {
    const Eigen::Quaterniond inverse = rotation.conjugate();
    return {inverse, -(inverse * translation)};
  }
};

/// The same rotation with w ≥ 0, the form everything is published in.
Eigen::Quaterniond Canonical(const Eigen::Quaterniond& rotation);

/// Exp: the rotation of |theta| radians about theta.
Eigen::Quaterniond RotationFromVector(const Eigen::Vector3d& theta);

/// Log: the smallest theta with RotationFromVector(theta) = rotation, radians.
Eigen::Vector3d VectorFromRotation(const Eigen::Quaterniond& rotation);

}  // namespace chequer

#pragma GCC visibility pop
