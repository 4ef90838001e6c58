#include "chequer/camera_model.h"

#include <Eigen/LU>
#include <cmath>

namespace chequer {
namespace {

/// Brown-Conrady as OpenCV writes it: radial k1 k2 k3, tangential p1 p2.
Eigen::Vector2d BrownConrady(const std::array<double, 5>& d, const Eigen::Vector2d& p, Eigen::Matrix2d* jacobian) {
  const double x = p.x(), y = p.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]));
  if (jacobian) {
    const double slope = 2 * (d[0] + r2 * (2 * d[1] + 3 * r2 * d[4]));  // d radial / d r2, times 2
    (*jacobian) << radial + slope * x * x + 2 * d[2] * y + 6 * d[3] * x, slope * x * y + 2 * d[2] * x + 2 * d[3] * y,
        slope * x * y + 2 * d[2] * x + 2 * d[3] * y, radial + slope * y * y + 6 * d[2] * y + 2 * d[3] * x;
  }
  return {x * radial + 2 * d[2] * x * y + d[3] * (r2 + 2 * x * x),
          y * radial + d[2] * (r2 + 2 * y * y) + 2 * d[3] * x * y};
}

/// OpenCV's fisheye: theta_d = theta (1 + k1 theta² + k2 theta⁴ + k3 theta⁶ + k4 theta⁸), along the same direction.
Eigen::Vector2d Fisheye(const std::array<double, 5>& d, const Eigen::Vector2d& p, Eigen::Matrix2d* jacobian) {
  const double r = p.norm();
  const double theta = std::atan(r), t2 = theta * theta;
  const double theta_d = theta * (1 + t2 * (d[0] + t2 * (d[1] + t2 * (d[2] + t2 * d[3]))));
  const double slope = 1 + t2 * (3 * d[0] + t2 * (5 * d[1] + t2 * (7 * d[2] + t2 * 9 * d[3])));
  if (r < 1e-9) {
    if (jacobian) jacobian->setIdentity();
    return p;
  }
  const double scale = theta_d / r;
  if (jacobian) {
    const Eigen::Vector2d direction = p / r;
    const double along = slope / (1 + r * r);
    *jacobian = scale * Eigen::Matrix2d::Identity() + (along - scale) * direction * direction.transpose();
  }
  return scale * p;
}

}  // namespace

Eigen::Vector2d CameraModel::Distort(const Eigen::Vector2d& normalized, Eigen::Matrix2d* jacobian) const {
  Eigen::Vector2d p = normalized;
  if (jacobian) jacobian->setIdentity();
  if (kind == Kind::kBrownConrady) p = BrownConrady(distortion, normalized, jacobian);
  if (kind == Kind::kFisheye) p = Fisheye(distortion, normalized, jacobian);
  if (jacobian) *jacobian = Eigen::Vector2d(fx, fy).asDiagonal() * *jacobian;
  return {fx * p.x() + cx, fy * p.y() + cy};
}

Eigen::Vector2d CameraModel::Distort(const Eigen::Vector2d& normalized) const { return Distort(normalized, nullptr); }

Eigen::Vector2d CameraModel::Project(const Eigen::Vector3d& x_in_camera) const {
  return Distort(Eigen::Vector2d(x_in_camera.x() / x_in_camera.z(), x_in_camera.y() / x_in_camera.z()), nullptr);
}

std::optional<Eigen::Vector2d> CameraModel::Undistort(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d distorted((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  if (kind == Kind::kPinhole) return distorted;
  Eigen::Vector2d p = distorted;
  if (kind == Kind::kFisheye) {
    // Newton on theta alone: it converges where Newton on the point does not (towards 90 degrees, where tan explodes).
    const double theta_d = distorted.norm();
    if (theta_d < 1e-9) return distorted;
    double theta = theta_d;
    for (int i = 0; i < 20; ++i) {
      const double t2 = theta * theta;
      const auto& d = distortion;
      const double f = theta * (1 + t2 * (d[0] + t2 * (d[1] + t2 * (d[2] + t2 * d[3])))) - theta_d;
      const double slope = 1 + t2 * (3 * d[0] + t2 * (5 * d[1] + t2 * (7 * d[2] + t2 * 9 * d[3])));
      if (!(slope > 0)) return std::nullopt;
      const double step = f / slope;
      theta -= step;
      if (std::abs(step) < 1e-13) break;
    }
    if (!(theta > 0 && theta < 1.55)) return std::nullopt;
    return distorted * (std::tan(theta) / theta_d);
  }
  for (int i = 0; i < 20; ++i) {
    Eigen::Matrix2d jacobian;
    const Eigen::Vector2d residual = BrownConrady(distortion, p, &jacobian) - distorted;
    // A fold of the polynomial has a singular derivative; beyond it the answer would be another point's.
    if (!(jacobian.determinant() > 1e-6) || !(jacobian.trace() > 0)) return std::nullopt;
    const Eigen::Vector2d step = jacobian.inverse() * residual;
    p -= step;
    if (step.squaredNorm() < 1e-26) return p;
  }
  const Eigen::Vector2d residual = BrownConrady(distortion, p, nullptr) - distorted;
  if (!(residual.norm() < 1e-9)) return std::nullopt;
  return p;
}

}  // namespace chequer
