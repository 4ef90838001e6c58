#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <vector>

#include "chequer/camera_model.h"
#include "simulate/background.h"
#include "simulate/lens.h"
#include "simulate/linear_image.h"
#include "simulate/stream_plan.h"

namespace chequer {

/// What lies behind the boards of one frame.
struct SeenBackground {
  std::shared_ptr<const LinearImage> drawn;  ///< before the lens, with a rim; shared with the frames that see the same
  LinearImage light;                         ///< through the lens
};

/// The background of a stream, which the camera's turns move. What frames have in common is worked out once.
class MovingBackground {
 public:
  MovingBackground(const Background& background, const CameraModel& camera, const std::vector<FramePlan>& frames,
                   const PointSpread& spread);

  /// Not from two threads at a time.
  SeenBackground At(const FramePlan& frame) const;

  int rim() const { return spread_.reach(); }

 private:
  LinearImage Turned(const FramePlan& frame) const;

  CameraModel camera_;
  const PointSpread& spread_;
  bool plain_;      ///< looks the same from everywhere
  int margin_ = 0;  ///< of the floor on all sides of the image, pixels
  LinearImage floor_;

  /// Of the last frame that saw it at rest and out of shadows.
  struct Kept {
    Eigen::Quaterniond camera_from_level = Eigen::Quaterniond::Identity();
    std::shared_ptr<const LinearImage> drawn;
    LinearImage light;
  };
  mutable std::optional<Kept> kept_;
};

}  // namespace chequer
