#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "chequer/geometry.h"
#include "chequer/marker.h"
#include "simulate/scene.h"

namespace chequer {

/// A marker that truly was in a frame.
struct TrueMarker {
  std::uint64_t id = 0;
  std::string variant;  ///< VariantName, or the peers' "tag36h11", "aruco4x4_1000"
  MarkerSize size;      ///< cells that the side counts
  double side_m = 0;    ///< of the longer counted side
  RigidTransform camera_from_marker;
  Eigen::Vector2d center_px{0, 0};  ///< of the board, in the image
  double cell_px = 0;               ///< the smallest pitch of its cells
  // Of streams; elsewhere all of a board is seen, at rest.
  double inside = 1;     ///< share of the board that lies in the image
  double visible = 1;    ///< share that lies in the image and is not occluded
  double motion_px = 0;  ///< of its farthest corner while the shutter is open
};

/// What truly was in a frame.
struct FrameTruth {
  std::string file;  ///< as in the recording
  std::vector<TrueMarker> markers;
  // Of streams alone.
  std::string phase{};             ///< its name; empty elsewhere
  std::optional<double> time_s{};  ///< of the middle of the exposure, since the stream began
};

/// What the truth says of a marker, in the image or not. @pre IsDrawable.
TrueMarker Describe(const SceneMarker& marker, const CameraModel& camera);

/// The truth of what a camera sees; markers that are not drawable or whose board lies wholly or partly outside the
/// frame are left out.
std::vector<TrueMarker> TruthOf(const std::vector<SceneMarker>& markers, const CameraModel& camera);

/// One line of a truth file: {"file", "markers": [{"id", "variant", "size", "side", "position", "orientation",
/// "center_px", "cell_px"}]}; metres, pixels, orientation w x y z with w ≥ 0. Of a stream also "phase" and "time_s",
/// and of each marker "inside", "visible" and "motion_px".
std::string ToJsonLine(const FrameTruth& truth);

/// Writes truth.jsonl's lines. Throws std::runtime_error naming the file where it cannot be written.
void WriteTruth(const std::filesystem::path& path, const std::vector<FrameTruth>& frames);

/// Reads them. Throws std::runtime_error naming file, line and what is wrong.
std::vector<FrameTruth> ReadTruth(const std::filesystem::path& path);

}  // namespace chequer
