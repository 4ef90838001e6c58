#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace chequer {

/// The shortest rotation that takes one direction to another. Opposite ones have many, of which it is any.
Eigen::Quaterniond RotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

struct NearestRotation {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d scales = Eigen::Vector3d::Ones();  ///< the matrix's singular values, the largest first
};
/// The rotation R that is nearest to a matrix by the squares of its entries, and makes tr(Rᵀ M) largest (Kabsch 1976).
NearestRotation FindNearestRotation(const Eigen::Matrix3d& matrix);

}  // namespace chequer
