#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "chequer/camera_model.h"
#include "chequer/frame.h"
#include "chequer/geometry.h"
#include "chequer/marker.h"

// What travels for those who look: requests to chequerd, and what it publishes on request alone. The .lcm files of the
// same names tell each field.

namespace chequer {

/// A rectangle of pixels of a frame; without width or height: the whole frame.
struct PixelRegion {
  int x = 0, y = 0, width = 0, height = 0;

  bool IsWhole() const { return width <= 0 || height <= 0; }
  bool operator==(const PixelRegion&) const = default;
};

/// A marker, as a request names it.
struct MarkerChoice {
  int family = 0;
  std::optional<std::uint64_t> id;                      ///< nothing: whichever is nearest to center_px
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();  ///< where it was seen last
};

/// Narrowest and widest preview that can be asked for, pixels.
inline constexpr int kLeastPreviewWidth = 16;
inline constexpr int kMostPreviewWidth = 1280;

/// A request: ask_t without LCM. What it does not hold is not wanted.
struct AskMessage {
  struct Preview {
    PixelRegion region;
    int width = 640;
  };
  std::int64_t asker = 0;
  bool wants_camera = false;
  std::optional<Preview> preview;
  std::optional<MarkerChoice> detail;
  bool wants_calibration = false;
};

/// preview_t without LCM.
struct PreviewMessage {
  UtcTime captured_utc{};
  std::uint64_t sequence = 0;
  std::string camera;
  std::int64_t asker = 0;
  int image_width = 0, image_height = 0;  ///< of the frame, pixels
  PixelRegion region;                     ///< of the frame, which the picture shows; never empty
  int width = 0, height = 0;              ///< of the picture, pixels
  std::vector<std::uint8_t> jpeg;
};

/// Mean and standard deviation.
struct NormalSummary {
  double mean = 0;
  double deviation = 0;
};

/// detail_cell_t without LCM.
struct DetailCell {
  std::array<Eigen::Vector2f, 4> outline_px = Zeros<Eigen::Vector2f, 4>();
  float luminance = 0;
  float saturation = 0;
  std::optional<bool> saturated;
  std::optional<bool> expected;
  bool seen = false;
  float log_likelihood = 0;
};

/// detail_t without LCM.
struct DetailMessage {
  UtcTime captured_utc{};
  std::uint64_t sequence = 0;
  std::string camera;
  std::int64_t asker = 0;
  bool found = false;
  std::string message;
  int family = 0;
  std::optional<std::uint64_t> id;
  Variant variant = Variant::kSecded;
  MarkerSize size{0, 0};
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
  int bits_corrected = 0;
  double reprojection_rms_px = 0;
  std::uint32_t warnings = 0;
  std::vector<Eigen::Vector2f> corners;  ///< NaN where not seen
  std::vector<DetailCell> cells;         ///< row by row
  NormalSummary luminance_dark, luminance_light, saturation_plain, saturation_saturated;
  double luminance_overlap = 0, saturation_overlap = 0;
};

/// camera_t without LCM.
struct CameraMessage {
  struct Family {
    Variant variant = Variant::kSecded;
    MarkerSize size;
    double side_m = 0;
  };
  UtcTime utc{};
  std::string camera;
  std::optional<CameraModel> model;
  std::optional<RigidTransform> world_from_camera;
  std::vector<Family> families;
};

/// Most residuals that a calibration_t holds.
inline constexpr std::size_t kMostCalibrationResiduals = 800;

/// calibration_t without LCM.
struct CalibrationMessage {
  enum class Kind : std::uint8_t { kLens, kWorld };
  enum class State : std::uint8_t { kCollecting, kSolving, kDone, kFailed };
  struct Residual {
    Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
    Eigen::Vector2f error_px = Eigen::Vector2f::Zero();  ///< seen minus expected
  };
  struct Reference {
    std::uint64_t id = 0;
    int frames = 0;                                          ///< in which it was seen
    Eigen::Vector2f center_px = Eigen::Vector2f::Zero();     ///< where
    std::optional<Eigen::Vector3f> offset_m = std::nullopt;  ///< in the world, seen minus said; nothing: not fitted
    double limit_m = 0;                                      ///< beyond which it contradicts the others; 0: unknown
  };
  UtcTime utc{};
  std::string camera;
  Kind kind = Kind::kLens;
  State state = State::kCollecting;
  std::string advice;
  int width = 0, height = 0;  ///< of the frames, pixels
  int frames = 0;             ///< that were looked at
  int views = 0, tilted = 0;  ///< of a lens: taken, and of them tilted
  double edge_px = 0;         ///< of a lens, in the newest view; 0: not measured
  int rows = 0, cols = 0;     ///< of `parts`
  std::vector<int> parts;     ///< of a lens: views that show a point in each part of the image, row by row
  double rms = 0;             ///< of a lens: pixels; of the world: metres; 0: nothing was fitted yet
  std::vector<Residual> residuals;
  std::vector<Reference> references;
};

}  // namespace chequer
