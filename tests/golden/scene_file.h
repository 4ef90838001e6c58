#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "chequer/detector.h"
#include "chequer/image.h"

namespace chequer::golden {

/// A marker that must be where it is.
struct ExpectedMarker {
  std::uint64_t id = 0;
  Variant variant = Variant::kSecded;
  MarkerSize size;
  double side_m = 0;  ///< of the longer side
  RigidTransform camera_from_marker;
  Eigen::Vector2d center_px{0, 0};
  double cell_px = 0;  ///< smallest pitch of its cells

  /// Inner corners row by row from the marker's top left, as the camera sees them, pixels.
  std::vector<Eigen::Vector2d> CornersPx(const CameraModel& camera) const;
};

/// A frame of a scene and all that is to be found in it.
struct ExpectedFrame {
  std::string file;
  std::vector<ExpectedMarker> markers;
};

/// How far a detection may be from the truth.
struct Tolerances {
  double corner_px = 0;
  double position_mm = 0;
  double angle_deg = 0;
};

/// A scene's folder: scene.toml, camera.toml, truth.jsonl and the frames.
struct GoldenScene {
  std::string name;
  std::string description;
  PixelFormat pixel_format = PixelFormat::kBgr8;  ///< BGR8, or what a one-channel file holds
  ToneCurve tone_curve = ToneCurve::Srgb();
  DetectorOptions options;
  int min_detections = 0;
  Tolerances tolerances;
  std::vector<ExpectedFrame> frames;
};

/// Reads a scene's folder. Throws std::runtime_error naming the file and what is wrong; also where scene.toml states
/// another number of frames than the folder or truth.jsonl holds.
GoldenScene LoadScene(const std::filesystem::path& folder);

/// Reads one of its frames. Throws std::runtime_error where it is no image.
Image LoadFrame(const std::filesystem::path& path, const GoldenScene& scene);

}  // namespace chequer::golden
