#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "publish/messages.h"
#include "simulate/truth.h"

namespace chequer {

/// What must hold for published poses to be right. A wrong id is never right; the rest leaves room for noise and for
/// frames that a loaded machine drops.
struct TruthTolerance {
  double least_frames = 0.9;    ///< published, of the recording's
  double least_markers = 0.99;  ///< found, of those that truly were in the published frames
  double position = 0.01;       ///< largest error, of the marker's distance
  double angle_deg = 5;         ///< largest error
};

/// Compares published poses with the truth of the recording that was replayed.
class TruthCheck {
 public:
  /// Throws std::runtime_error naming the recording where it has no truth or cannot be read.
  explicit TruthCheck(const std::filesystem::path& recording, TruthTolerance tolerance = {});

  /// A frame was published; it is matched with the recording's by its sequence number.
  void Add(const PosesMessage& message);

  bool Passed() const;
  /// One line: counts, errors, and what was not right, if anything.
  std::string Summary() const;

 private:
  void Compare(const MarkerPose& found, const TrueMarker& truth);
  std::vector<std::string> Failures() const;

  TruthTolerance tolerance_;
  std::size_t frames_in_recording_ = 0;
  std::map<std::uint64_t, std::vector<TrueMarker>> unseen_frames_;  ///< by sequence number
  std::size_t frames_ = 0;
  std::size_t strange_frames_ = 0;  ///< that are not in the recording, or came twice
  std::size_t markers_in_frames_ = 0;  ///< whole ones
  std::size_t found_ = 0;              ///< of these
  std::size_t compared_ = 0;           ///< poses
  std::size_t wrong_ids_ = 0;    ///< not in that frame, or twice
  std::size_t wrong_poses_ = 0;  ///< beyond the tolerance, or missing
  double sum_squared_error_m_ = 0;
  double worst_error_m_ = 0;
  double worst_relative_error_ = 0;
  double worst_angle_deg_ = 0;
};

}  // namespace chequer
