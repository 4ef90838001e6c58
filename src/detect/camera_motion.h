#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "detect/fit_schedule.h"
#include "detect/image_state.h"

// What the boards of a stream's frame make of a camera that was knocked (memory/common_motion.h).

namespace chequer {

/// So many boards tell the motion of the camera from their own.
inline constexpr std::size_t kFewestThatMoved = 3;

/// Whether a board of a stream's frame is blurred by motion: then others may be.
bool ShowsMotion(const ImageState& frame);
/// Learns from boards that were fitted in full how the camera moved.
void LearnMotion(const ImageJob& job, std::span<const FitTask> fitted);
/// Starts the fit of a board that was expected where the camera took it, and with the motion that it had by then.
void FollowCamera(const ImageJob& job, std::size_t board, PhotometricFit::Start& start);

/// Where the last frame would have shown boards, had the camera already stood as it does now.
class LastPlaces {
 public:
  /// Once all boards are fitted.
  explicit LastPlaces(const ImageJob& job);

  Eigen::Matrix3d Of(const Eigen::Matrix3d& plane_from_board) const;
  /// Whether that is where it did show them.
  bool same() const { return shift_px_.isZero() && turn_.by.isZero(); }

 private:
  const Lens& lens_;
  Eigen::Vector2d shift_px_ = Eigen::Vector2d::Zero();  ///< as it was found before the fits
  CameraTurn turn_;                                     ///< what these add to it
};

}  // namespace chequer
