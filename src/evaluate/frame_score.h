#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "chequer/geometry.h"
#include "simulate/truth.h"

namespace chequer {

/// A marker as results have it.
struct FoundMarker {
  std::optional<std::uint64_t> id;  ///< empty where undecided
  std::string variant;              ///< empty where the results do not say
  Eigen::Vector2d center_px{0, 0};  ///< of the board
  std::optional<RigidTransform> camera_from_marker;
  std::optional<Matrix6d> covariance;  ///< of (x, y, z, θx, θy, θz), m and rad
  bool carried = false;                ///< the id is known from earlier frames, not read in this one
};

/// What came of one frame.
struct FoundFrame {
  std::vector<FoundMarker> markers;
  std::optional<double> detect_ms;   ///< that detection took
  std::optional<double> latency_ms;  ///< from capture to publication
};

/// How far a pose is from the truth.
struct PoseError {
  double position_mm = 0;
  double angle_deg = 0;
  bool carried = false;  ///< as of FoundMarker
  // Squared errors over the covariance, divided by their three dimensions: 1 on average where the covariance is right.
  std::optional<double> position_over_covariance{};
  std::optional<double> rotation_over_covariance{};
};

/// A frame's markers against its truth.
struct FrameScore {
  int expected = 0;  ///< boards with at least kLeastInside of them in the image
  int read = 0;      ///< of these, those whose id was read
  int carried = 0;   ///< of those that were read, those whose id was carried from earlier frames
  int whole = 0;     ///< of the expected, those that are seen from rim to rim, nothing occluded
  int whole_read = 0;
  int undecided = 0;              ///< detections without an id
  int wrong = 0;                  ///< ids that are read where a board of another id is
  int twice = 0;                  ///< ids that are read once more where their board is
  int ghosts = 0;                 ///< ids that are read where no board is
  std::vector<PoseError> errors;  ///< of the boards that were read and have a pose, also of those not expected

  FrameScore& operator+=(const FrameScore& other);
  double Recall() const { return expected == 0 ? 1 : static_cast<double>(read) / expected; }
};

/// Of a board more of which is outside, nobody expects to read it.
inline constexpr double kLeastInside = 0.5;

/// Compares a frame with its truth. A detection is of the true board whose middle is nearest to its own, if it lies
/// within half a side.
FrameScore ScoreFrame(const FoundFrame& found, const FrameTruth& truth);

}  // namespace chequer
