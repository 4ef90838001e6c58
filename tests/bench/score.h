#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "chequer/camera_model.h"
#include "chequer/geometry.h"
#include "evaluate/track.h"

namespace chequer::bench {

/// A marker that truly is in a frame.
struct TrueMarker {
  std::uint64_t id = 0;
  RigidTransform camera_from_marker;
  Eigen::Vector2d center_px{0, 0};  ///< of the board, in the image
  double cell_px = 0;               ///< smallest pitch of its cells
};

/// A marker that a detector reports.
struct Detection {
  std::optional<std::uint64_t> id;  ///< empty: a board whose identity was left undecided
  RigidTransform camera_from_marker;
};

/// Of the markers that were found with their right id, against the truth; camera frame.
struct PoseErrors {
  double position_rms_mm = 0;
  double position_median_mm = 0;
  double lateral_rms_mm = 0;  ///< across the line of sight
  double depth_rms_mm = 0;    ///< along the line of sight
  double angle_rms_deg = 0;
  double angle_median_deg = 0;
};

struct Score {
  int markers = 0;                   ///< true ones
  int hits = 0;                      ///< of them, found with the right id in the right place
  int wrong = 0;                     ///< detections with an id that are none of these
  int undecided = 0;                 ///< detections without an id
  std::optional<PoseErrors> pose;    ///< where there are hits
  std::optional<TrackErrors> track;  ///< where there are at least three hits; see evaluate/track.h

  double Recall() const { return markers == 0 ? 1.0 : static_cast<double>(hits) / markers; }
};

/// Holds detections against the truth, frame by frame.
class ScoreKeeper {
 public:
  explicit ScoreKeeper(const CameraModel& camera) : camera_(camera) {}

  /// A true marker is hit by the nearest detection of its id whose centre is within 3 px or one cell of its own,
  /// whichever is more; every detection hits at most one.
  void AddFrame(std::span<const TrueMarker> truth, std::span<const Detection> detections);

  Score Summary() const;

 private:
  void AddHit(const TrueMarker& truth, const RigidTransform& found);

  CameraModel camera_;
  Score counts_;
  std::vector<RigidTransform> found_;
  std::vector<double> position_m_;
  std::vector<double> lateral_m_;
  std::vector<double> depth_m_;
  std::vector<double> angle_deg_;
};

/// The middle value; the mean of the two middle ones of an even number. @pre not empty.
double Median(std::vector<double> values);

/// Frames of a stream until a memory knows how its boards move.
inline constexpr int kFramesUntilKnown = 4;

/// Mean of what a stream's frames have taken, without the first kFramesUntilKnown, which count for nothing in a stream
/// of hours. Some frames of a stream are to cost more than others, which a median would hide. @pre there are more.
double MeanOfStream(std::span<const double> frames);

}  // namespace chequer::bench
