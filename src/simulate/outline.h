#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "chequer/camera_model.h"
#include "simulate/coverage.h"
#include "simulate/scene.h"

namespace chequer {

/// Light that a glossy surface adds: peak · exp(−½ dᵀ · inverse_covariance · d), d from its middle, pixels.
struct Glow {
  Eigen::Array3f peak = Eigen::Array3f::Zero();
  Eigen::Vector2d center{0, 0};
  Eigen::Matrix2d inverse_covariance = Eigen::Matrix2d::Identity();

  Eigen::Array3f At(const Eigen::Vector2d& pixel) const;
};

/// Something flat that is drawn over what lies below it: the outlines of all its cells in pixels of the (distorted)
/// frame.
struct Layer {
  std::vector<OutlineEdge> edges;
  Eigen::Vector2d low{0, 0};  ///< of all points, pixels
  Eigen::Vector2d high{0, 0};
  // Light on it at pixel p: 1 − fall · clamp(fall_offset + fall_direction · p, 0, 1).
  double fall = 0;
  double fall_offset = 0;
  Eigen::Vector2d fall_direction{0, 0};  ///< per pixel
  std::optional<Glow> glow{};
};

/// The layers of markers from below to above. Markers that are not drawable are left out.
std::vector<Layer> MakeLayers(const std::vector<SceneMarker>& markers, const CameraModel& camera);

/// How a marker goes on while a rolling shutter exposes one row after the other, as far as it lies in them: evenly.
struct MotionByRow {
  double row = 0;                                  ///< of which the poses are, pixels
  Eigen::Vector3d step = Eigen::Vector3d::Zero();  ///< of its middle from a row to the next, metres
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  ///< rotation vector, camera frame, from a row to the next
};

/// A marker that moves while the shutter is open.
struct MovingMarker {
  SceneMarker marker;                              ///< without a gradient
  std::vector<RigidTransform> camera_from_marker;  ///< at instants that are spread evenly over the exposure, at least 1
  MotionByRow by_row{};
};

/// One layer a marker: the mean of what is seen at all instants. Coverage adds up as light does, so the mean is as
/// exact as one instant. What lies on a marker is cut out of it, so that a layer covers no place twice.
/// @pre at no instant do two markers overlap in the image.
std::vector<Layer> MakeMovingLayers(const std::vector<MovingMarker>& markers, const CameraModel& camera);

}  // namespace chequer
