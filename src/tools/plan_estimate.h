#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "chequer/camera_model.h"
#include "chequer/image.h"
#include "chequer/marker.h"
#include "simulate/render.h"

namespace chequer {

/// What is planned: markers of one kind, seen from one distance.
struct PlanScene {
  RenderOptions view;  ///< the camera and its conditions
  MarkerCode code{MarkerSize{}, Variant::kSecded};
  double side_m = 0;
  double distance_m = 0;  ///< of the markers' plane from the camera, along its axis
  double max_tilt_rad = 0.09;
  int trials = 40;
  std::uint64_t seed = 1;
};

enum class PlanVerdict : std::uint8_t { kRead, kDoubtful, kNotRead };

/// What is to be expected of it.
struct PlanEstimate {
  double cell_px = 0;  ///< side of a cell in the middle of the image, seen straight
  /// Rendered markers at random places in the image, turned and tilted at random, and what the detector made of them.
  int trials = 0;
  int read = 0;
  int wrong = 0;
  /// Of those that were read, poses that are the mirror image of the true one: small markers that face the camera look
  /// alike both ways. Each has the warning ambiguous_pose.
  int mirrored = 0;
  /// Root mean square errors of the others: x and y across, z away from the camera, m; about the camera's x,
  /// y and z axes, rad. Zero where none was read.
  Eigen::Vector3d error_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d error_rad = Eigen::Vector3d::Zero();
  /// The same of the best possible detector: the Cramér–Rao bound of rendered markers.
  Eigen::Vector3d bound_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d bound_rad = Eigen::Vector3d::Zero();
  Eigen::Vector2d seen_m = Eigen::Vector2d::Zero();  ///< width and height of what the image shows at that distance
  double smallest_side_m = 0;                        ///< whose cells are kSafeCellPx wide
  double farthest_m = 0;                             ///< from where cells are so wide
  bool fits = true;                                  ///< whether a whole marker fits into the image

  PlanVerdict Verdict() const;
};

/// Renders and detects: half a second. @pre view.Check() is empty; side and distance are above 0.
PlanEstimate EstimatePlan(const PlanScene& scene);

/// One of the rendered markers, for the picture: BGR8, about four boards wide.
Image RenderPlanned(const PlanScene& scene);

}  // namespace chequer
