#include "core/lens_parameters.h"

#include <cmath>

namespace chequer {
namespace {

constexpr double kLeastDepthM = 1e-6;

/// Derivative of the distorted point of the plane z = 1 by the coefficients.
void ByCoefficients(CameraModel::Kind kind, const Eigen::Vector2d& p, Eigen::Matrix<double, 2, 5>& by) {
  const double x = p.x(), y = p.y(), r2 = p.squaredNorm();
  by.setZero();
  if (kind == CameraModel::Kind::kBrownConrady) {
    by.col(0) = p * r2;
    by.col(1) = p * r2 * r2;
    by.col(2) = Eigen::Vector2d(2 * x * y, r2 + 2 * y * y);
    by.col(3) = Eigen::Vector2d(r2 + 2 * x * x, 2 * x * y);
    by.col(4) = p * r2 * r2 * r2;
  }
  if (kind == CameraModel::Kind::kFisheye && r2 > 1e-18) {
    const double r = std::sqrt(r2), theta = std::atan(r);
    double power = theta * theta * theta;
    for (int i = 0; i < 4; ++i, power *= theta * theta) by.col(i) = p / r * power;
  }
}

}  // namespace

int LensParameterCount(CameraModel::Kind kind) {
  switch (kind) {
    case CameraModel::Kind::kPinhole: return 4;
    case CameraModel::Kind::kFisheye: return 8;
    case CameraModel::Kind::kBrownConrady: return 9;
  }
  return 4;
}

double& LensParameter(CameraModel& camera, int index) {
  switch (index) {
    case 0: return camera.fx;
    case 1: return camera.fy;
    case 2: return camera.cx;
    case 3: return camera.cy;
    default: return camera.distortion[static_cast<std::size_t>(index - 4)];
  }
}

std::optional<SeenWithDerivatives> ProjectWithDerivatives(const CameraModel& camera,
                                                          const Eigen::Vector3d& x_in_camera) {
  if (!(x_in_camera.z() > kLeastDepthM)) return std::nullopt;
  const double z = x_in_camera.z();
  const Eigen::Vector2d p = x_in_camera.head<2>() / z;
  SeenWithDerivatives seen;
  Eigen::Matrix2d by_normalized;
  seen.pixel = camera.Distort(p, &by_normalized);
  Eigen::Matrix<double, 2, 3> normalized_by_point;
  normalized_by_point << 1 / z, 0, -p.x() / z, 0, 1 / z, -p.y() / z;
  seen.by_point = by_normalized * normalized_by_point;
  Eigen::Matrix<double, 2, 5> by_coefficients;
  ByCoefficients(camera.kind, p, by_coefficients);
  seen.by_lens.setZero();
  seen.by_lens(0, 0) = (seen.pixel.x() - camera.cx) / camera.fx;
  seen.by_lens(1, 1) = (seen.pixel.y() - camera.cy) / camera.fy;
  seen.by_lens(0, 2) = seen.by_lens(1, 3) = 1;
  seen.by_lens.row(0).tail<5>() = camera.fx * by_coefficients.row(0);
  seen.by_lens.row(1).tail<5>() = camera.fy * by_coefficients.row(1);
  return seen;
}

}  // namespace chequer
