#include "core/rotations.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <numbers>

namespace chequer {

Eigen::Quaterniond RotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized(), b = to.normalized();
  const double cosine = a.dot(b);
  // The sum of a half turn and none has half of the angle, but no length where the directions are opposite.
  if (cosine < -1 + 1e-12) return Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, a.unitOrthogonal()));
  Eigen::Quaterniond rotation;
  rotation.w() = 1 + cosine;
  rotation.vec() = a.cross(b);
  return rotation.normalized();
}

NearestRotation FindNearestRotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // Where the nearest orthogonal matrix is a mirror, its least direction is turned over.
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return {svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose(), svd.singularValues()};
}

}  // namespace chequer
