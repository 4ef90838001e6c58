#include "bench/hard_scenes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string_view>
#include <utility>

#include "simulate/board.h"
#include "simulate/processing.h"

namespace chequer::bench {
namespace {

constexpr double kFocalPx = 1000;
constexpr int kWidth = 640, kHeight = 480;

double Turn(Random& random) { return random.Uniform(0, 2 * std::numbers::pi); }

/// Of a frame, or of the print that all its boards are of.
struct FrameCondition {
  const char* name;
  double share;  ///< of frames
  bool stays;    ///< for all of a stream
  void (*apply)(Random&, RenderOptions&, std::vector<SceneMarker>&);
};

constexpr FrameCondition kFrameConditions[] = {
    {"blur", 0.15, false, [](Random& random, RenderOptions& to, auto&) { to.blur_sigma_px = random.Uniform(1, 2.2); }},
    {"noise", 0.15, false,
     [](Random& random, RenderOptions& to, auto&) { to.sensor.full_well_electrons = random.LogUniform(300, 3000); }},
    {"dark", 0.12, false,
     [](Random& random, RenderOptions& to, auto&) { to.sensor.exposure = random.Uniform(0.06, 0.4); }},
    {"overexposed", 0.1, false,
     [](Random& random, RenderOptions& to, auto&) { to.sensor.exposure = random.Uniform(1.1, 1.7); }},
    {"haze", 0.15, false,
     [](Random& random, RenderOptions& to, auto&) { to.lighting.haze = random.Uniform(0.05, 0.35); }},
    {"balance", 0.2, false,
     [](Random& random, RenderOptions& to, auto&) {
       to.sensor.white_balance = {random.Uniform(0.75, 1.3), 1, random.Uniform(0.75, 1.3)};
     }},
    {"vignetting", 0.2, false,
     [](Random& random, RenderOptions& to, auto&) { to.lighting.vignetting = random.Uniform(0.1, 0.6); }},
    {"motion", 0.3, false,
     [](Random& random, RenderOptions& to, auto&) {
       to.motion_px = random.Uniform(0.5, 10);
       to.motion_angle_rad = Turn(random);
     }},
    {"jpeg", 0.1, true,
     [](Random& random, RenderOptions& to, auto&) {
       to.format = PixelFormat::kBgr8;
       to.jpeg_quality = static_cast<int>(random.Uniform(60, 96));
     }},
    {"shadow", 0.25, false,
     [](Random& random, RenderOptions& to, auto&) {
       to.shadow = {.takes = random.Uniform(0.2, 0.85),
                    .direction_rad = Turn(random),
                    .through_x = kWidth * random.Uniform(0.25, 0.75),
                    .through_y = kHeight * random.Uniform(0.25, 0.75),
                    .width_px = random.LogUniform(0.5, 12)};
     }},
    {"ink", 0.3, true,
     [](Random& random, RenderOptions&, std::vector<SceneMarker>& markers) {
       const double cells = random.Uniform(0.02, 0.12);
       for (SceneMarker& marker : markers) marker.ink_spread_cells = cells;
     }},
    {"bent", 0.08, true,
     [](Random& random, RenderOptions&, std::vector<SceneMarker>& markers) {
       for (SceneMarker& marker : markers) {
         marker.bend_per_m = 1 / random.LogUniform(0.3, 3);
         marker.bend_angle_rad = Turn(random);
       }
     }},
    {"webcam", 0.15, true,
     [](Random& random, RenderOptions& to, auto&) {
       constexpr std::string_view kNames[] = {"webcam-mjpeg", "webcam-yuyv", "webcam-nv12"};
       const CameraPreset preset = *FindCameraPreset(kNames[random.Below(3)]);
       to.format = preset.format;
       to.jpeg_quality = preset.jpeg_quality;
       to.processing = preset.processing;
       to.processing.chromatic_aberration_px = 0;  // which moves boards; a calibration of the lens would take it up
     }},
    {"processed", 0.1, true,
     [](Random& random, RenderOptions& to, auto&) {
       if (to.format == PixelFormat::kBayerRg8) to.format = PixelFormat::kBgr8;
       to.processing.sharpening = random.Uniform(0, 1.5);
       to.processing.denoising_levels = random.Uniform(0, 6);
       to.processing.saturation = random.Uniform(0.9, 1.4);
     }},
};

/// A side, a corner or a strip across the board, of one colour or in patches.
void Cover(Random& random, SceneMarker& marker) {
  const double part = random.Uniform(0.05, 0.45), from = random.Uniform(-0.1, 0.8);
  const Occluder kinds[] = {{.from = {-0.1, -0.1}, .to = {1.1, part}},
                            {.from = {1 - part, -0.1}, .to = {1.1, 1.1}},
                            {.from = {-0.1, -0.1}, .to = {part, part}},
                            {.from = {from, -0.1}, .to = {from + part / 2, 1.1}}};
  Occluder cover = kinds[random.Below(4)];
  cover.patches = random.Below(2) == 0 ? 0 : 8;
  for (float& value : cover.colour) value = static_cast<float>(random.Uniform(0.02, 0.8));
  cover.seed = random.Bits();
  marker.occluders.push_back(cover);
}

struct BoardCondition {
  const char* name;
  double share;  ///< of boards
  bool stays;    ///< for all of a stream
  void (*apply)(Random&, SceneMarker&);
};

constexpr BoardCondition kBoardConditions[] = {
    {"tilt", 0.3, true,
     [](Random& random, SceneMarker& marker) {
       marker.camera_from_marker =
           FacingPose(marker.camera_from_marker.translation, Turn(random), random.Uniform(0.3, 1.1), Turn(random));
     }},
    {"gradient", 0.15, false,
     [](Random& random, SceneMarker& marker) {
       marker.gradient = random.Uniform(0.2, 0.7);
       marker.gradient_angle_rad = Turn(random);
     }},
    {"gloss", 0.08, false,
     [](Random& random, SceneMarker& marker) {
       marker.highlight = {.strength = random.Uniform(0.1, 0.8),
                           .at = {random.Uniform(), random.Uniform()},
                           .sigma = random.Uniform(0.1, 0.4)};
     }},
    {"cover", 0.2, false, Cover},
};

/// One to nine boards, by their size, each in a place of its own.
void PlaceBoards(Random& random, const MarkerCode& code, Scene& scene) {
  const double side_px = random.LogUniform(30, 200), ids = static_cast<double>(code.max_id()) + 1;
  const int across = side_px < 60 ? 3 : side_px < 120 ? 2 : 1;
  const InkSet inks = *NamedInks(std::array{"laser", "inkjet", "matte"}[static_cast<std::size_t>(random.Below(3))]);
  for (int i = 0; i < across * across; ++i) {
    SceneMarker marker;
    marker.board = MakeBoard(code, static_cast<std::uint64_t>(random.Uniform() * ids));
    marker.side_m = HardFrame::kSideM;
    marker.inks = inks;
    const double depth = HardFrame::kSideM * kFocalPx / side_px * random.Uniform(0.95, 1.1),
                 m_per_px = depth / kFocalPx,
                 x = (i % across + random.Uniform(0.45, 0.55)) * kWidth / across - 0.5 * kWidth,
                 y = (i / across + random.Uniform(0.45, 0.55)) * kHeight / across - 0.5 * kHeight;
    marker.camera_from_marker =
        FacingPose({x * m_per_px, y * m_per_px, depth}, Turn(random), random.Uniform(0, 0.3), Turn(random));
    scene.markers.push_back(std::move(marker));
  }
}

/// What is in no hard condition.
HardFrame DrawPlainFrame(Random& random, Variant variant) {
  HardFrame frame;
  RenderOptions& render = frame.render;
  render.camera = {
      .width = kWidth, .height = kHeight, .fx = kFocalPx, .fy = kFocalPx, .cx = 0.5 * kWidth, .cy = 0.5 * kHeight};
  render.camera.kind = CameraModel::Kind::kBrownConrady;
  render.camera.distortion = {-0.1, 0.02, 0, 0, 0};
  render.blur_sigma_px = random.Uniform(0.5, 1);
  render.sensor.full_well_electrons = random.LogUniform(3000, 20000);
  render.sensor.exposure = random.Uniform(0.5, 1.05);
  if (random.Below(2) == 0) render.format = PixelFormat::kBayerRg8;
  constexpr BackgroundKind kKinds[] = {BackgroundKind::kPlain, BackgroundKind::kNoise, BackgroundKind::kTiles,
                                       BackgroundKind::kWood};
  frame.scene.background.kind = kKinds[random.Below(4)];
  frame.scene.background.seed = random.Bits();
  PlaceBoards(random, MarkerCode({6, 6}, variant), frame.scene);
  frame.conditions.resize(frame.scene.markers.size());
  return frame;
}

/// Whether a frame or board has a condition.
template <class Condition>
bool Has(const HardSceneOptions& options, const Condition& condition, Random& random) {
  const auto& only = options.only;
  const bool may = only.empty() || std::find(only.begin(), only.end(), condition.name) != only.end();
  return random.Uniform() < (options.share > 0 ? options.share : condition.share) && may;
}

/// @param may which conditions are looked at.
template <class May>
void AddFrameConditions(const HardSceneOptions& options, May may, Random& random, HardFrame& frame) {
  for (const FrameCondition& condition : kFrameConditions) {
    if (!may(condition) || !Has(options, condition, random)) continue;
    condition.apply(random, frame.render, frame.scene.markers);
    for (auto& conditions : frame.conditions) conditions.push_back(condition.name);
  }
}

template <class May>
void AddBoardConditions(const HardSceneOptions& options, May may, Random& random, HardFrame& frame, std::size_t board) {
  for (const BoardCondition& condition : kBoardConditions) {
    if (!may(condition) || !Has(options, condition, random)) continue;
    condition.apply(random, frame.scene.markers[board]);
    frame.conditions[board].push_back(condition.name);
  }
}

constexpr auto kAll = [](const auto&) { return true; };
constexpr auto kStays = [](const auto& condition) { return condition.stays; };
constexpr auto kChanges = [](const auto& condition) { return !condition.stays; };

/// Of a frame after the first: that light changes, and that something is put on a board or taken off.
constexpr double kLightChanges = 0.15, kBoardChanges = 0.1;

}  // namespace

std::optional<std::size_t> HardFrame::BoardOf(const RigidTransform& camera_from_marker) const {
  const auto far = [&](const SceneMarker& marker) {
    return (camera_from_marker.translation.hnormalized() - marker.camera_from_marker.translation.hnormalized()).norm();
  };
  const auto nearest = std::min_element(scene.markers.begin(), scene.markers.end(),
                                        [&](const auto& a, const auto& b) { return far(a) < far(b); });
  if (far(*nearest) > kSideM / nearest->camera_from_marker.translation.z() / 2) return std::nullopt;
  return static_cast<std::size_t>(nearest - scene.markers.begin());
}

HardFrame DrawHardFrame(const HardSceneOptions& options, std::uint64_t seed) {
  Random random(900000 + seed);
  HardFrame frame = DrawPlainFrame(random, options.variant);
  AddFrameConditions(options, kAll, random, frame);
  for (std::size_t i = 0; i < frame.conditions.size(); ++i) AddBoardConditions(options, kAll, random, frame, i);
  return frame;
}

HardStream::HardStream(const HardSceneOptions& options, std::uint64_t seed)
    : options_(options), random_(900000 + seed) {
  Random stays(random_.Bits());
  light_seed_ = random_.Bits();
  plain_ = DrawPlainFrame(random_, options.variant);
  AddFrameConditions(options_, kStays, stays, plain_);
  for (std::size_t i = 0; i < plain_.conditions.size(); ++i) {
    AddBoardConditions(options_, kStays, stays, plain_, i);
    const SceneMarker& marker = plain_.scene.markers[i];
    const double place_px = 1.5 * HardFrame::kSideM / marker.camera_from_marker.translation.z() * kFocalPx;
    drives_.push_back({.radius_px = 0.12 * place_px * random_.Uniform(),
                       .turn_rad = random_.Uniform(-0.4, 0.4),
                       .from_rad = Turn(random_),
                       .yaw_rad = random_.Uniform(-0.08, 0.08),
                       .seed = random_.Bits()});
  }
}

HardFrame HardStream::Next() {
  if (frames_ > 0 && random_.Uniform() < kLightChanges) light_seed_ = random_.Bits();
  HardFrame frame = plain_;
  Random lights(light_seed_);
  AddFrameConditions(options_, kChanges, lights, frame);
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    Drive& drive = drives_[i];
    if (frames_ > 0 && random_.Uniform() < kBoardChanges) drive.seed = random_.Bits();
    Random on_board(drive.seed);
    AddBoardConditions(options_, kChanges, on_board, frame, i);
    RigidTransform& pose = frame.scene.markers[i].camera_from_marker;
    const double angle = drive.from_rad + frames_ * drive.turn_rad,
                 radius = drive.radius_px / kFocalPx * pose.translation.z();
    pose.translation += radius * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    pose.rotation = pose.rotation * Eigen::AngleAxisd(frames_ * drive.yaw_rad, Eigen::Vector3d::UnitZ());
  }
  ++frames_;
  return frame;
}

}  // namespace chequer::bench
