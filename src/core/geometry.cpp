#include "chequer/geometry.h"

#include <cmath>

namespace chequer {

Eigen::Quaterniond Canonical(const Eigen::Quaterniond& rotation) {
  return rotation.w() < 0 ? Eigen::Quaterniond(-rotation.coeffs()) : rotation;
}

Eigen::Quaterniond RotationFromVector(const Eigen::Vector3d& theta) {
  const double angle = theta.norm();
  // sin(a/2)/a, by its series where the quotient would lose its digits.
  const double scale = angle < 1e-6 ? 0.5 - angle * angle / 48 : std::sin(angle / 2) / angle;
  Eigen::Quaterniond rotation;
  rotation.w() = std::cos(angle / 2);
  rotation.vec() = scale * theta;
  return rotation;
}

Eigen::Vector3d VectorFromRotation(const Eigen::Quaterniond& rotation) {
  const Eigen::Quaterniond q = Canonical(rotation);
  const double sine = q.vec().norm();
  const double scale = sine < 1e-9 ? 2.0 / q.w() : 2 * std::atan2(sine, q.w()) / sine;
  return scale * q.vec();
}

}  // namespace chequer
