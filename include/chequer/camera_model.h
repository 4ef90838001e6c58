#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "chequer/tone_curve.h"

#pragma GCC visibility push(default)  // part of libchequer's interface

namespace chequer {

/// Covariance of fx, fy, cx, cy (pixels) and, in their order, of the distortion coefficients; zero for those that a
/// model does not have.
using LensCovariance = Eigen::Matrix<double, 9, 9>;

/// A calibrated lens, with OpenCV's definitions. Pixels; the centre of the top-left pixel is (0, 0).
struct CameraModel {
  enum class Kind { kPinhole, kBrownConrady, kFisheye };

  int width = 0;  ///< of the images it was calibrated for, pixels
  int height = 0;
  double fx = 1, fy = 1;  ///< pixels
  double cx = 0, cy = 0;  ///< pixels
  Kind kind = Kind::kPinhole;
  /// brown_conrady: k1 k2 p1 p2 k3; fisheye: k1 k2 k3 k4 (the fifth unused).
  std::array<double, 5> distortion{};
  /// The curve of the images' values, where it was measured: the detector then takes it, whatever the images state.
  std::optional<ToneCurve> tone_curve{};
  /// How far the calibration may be off, the same in all images: it goes into the poses' covariances. Zero: nothing is
  /// known of it, and poses are as exact as images tell.
  LensCovariance covariance = LensCovariance::Zero();
  /// By how many milliseconds a frame's last row is exposed later than its first: a rolling shutter; 0: all are exposed
  /// at once. It shears boards that move, which the detector undoes where a memory tells how they do.
  double rows_read_ms = 0;

  /// Pixel of a point in the camera frame. @pre z > 0.
  Eigen::Vector2d Project(const Eigen::Vector3d& x_in_camera) const;

  /// Pixel of a point of the plane z = 1.
  Eigen::Vector2d Distort(const Eigen::Vector2d& normalized) const;

  /// Pixel, and its derivative by the point of the plane z = 1.
  Eigen::Vector2d Distort(const Eigen::Vector2d& normalized, Eigen::Matrix2d* jacobian) const;

  /// The point of the plane z = 1 that is seen at a pixel; nothing where the lens model has no inverse there
  /// (beyond the radius at which the distortion polynomial turns back).
  std::optional<Eigen::Vector2d> Undistort(const Eigen::Vector2d& pixel) const;
};

}  // namespace chequer

#pragma GCC visibility pop
