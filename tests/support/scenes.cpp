#include "support/scenes.h"

#include <array>
#include <cmath>
#include <utility>

#include "simulate/random.h"

namespace chequer::test {

CameraModel PlainCamera(int width, int height, double focal_px) {
  return {.width = width,
          .height = height,
          .fx = focal_px,
          .fy = focal_px,
          .cx = 0.5 * (width - 1),
          .cy = 0.5 * (height - 1)};
}

SceneMarker MarkerOf(const MarkerCode& code, std::uint64_t id, const RigidTransform& camera_from_marker,
                     double side_m) {
  SceneMarker marker;
  marker.board = MakeBoard(code, id);
  marker.side_m = side_m;
  marker.camera_from_marker = camera_from_marker;
  return marker;
}

KnownFrame OneMarker(const MarkerCode& code, std::uint64_t id, double cell_px, std::uint64_t seed, double tilt_rad) {
  Random random(seed);
  KnownFrame frame;
  frame.name = ToString(code.size()) + " " + std::string(VariantName(code.variant())) + " " + std::to_string(id) +
               ", seed " + std::to_string(seed);
  frame.seed = seed;
  frame.options.camera = PlainCamera();
  SceneMarker marker = MarkerOf(code, id, {});
  const double focal_px = frame.options.camera.fx;
  const double depth = focal_px * marker.CellSize() / cell_px;
  // One by one: a compiler draws the arguments of a call in an order of its own.
  const double down_px = random.Uniform(-5, 5), right_px = random.Uniform(-5, 5);
  const Eigen::Vector2d place = Eigen::Vector2d(right_px, down_px) * depth / focal_px;
  const double tilt_axis_rad = random.Uniform(0, 2 * M_PI), heading_rad = random.Uniform(0, 2 * M_PI);
  marker.camera_from_marker = FacingPose({place.x(), place.y(), depth}, heading_rad, tilt_rad, tilt_axis_rad);
  frame.scene.markers.push_back(std::move(marker));
  return frame;
}

std::vector<Eigen::Vector2d> InnerCorners(const SceneMarker& marker, const CameraModel& camera) {
  std::vector<Eigen::Vector2d> corners;
  for (int row = 1; row < marker.board.rows; ++row)
    for (int col = 1; col < marker.board.cols; ++col)
      corners.push_back(camera.Project(marker.camera_from_marker * marker.PointAt(col, row)));
  return corners;
}

std::vector<KnownFrame> ClutterFrames(int count, std::uint64_t seed, int width, int height) {
  constexpr std::array kKinds{BackgroundKind::kNoise, BackgroundKind::kChess, BackgroundKind::kText,
                              BackgroundKind::kTiles, BackgroundKind::kWood,  BackgroundKind::kBlobs,
                              BackgroundKind::kMixed};
  Random random(seed);
  std::vector<KnownFrame> frames;
  for (int i = 0; i < count; ++i) {
    KnownFrame frame;
    frame.seed = random.Bits();
    frame.options.camera = PlainCamera(width, height);
    frame.options.blur_sigma_px = random.Uniform(0.4, 1.5);
    frame.options.sensor.exposure = random.LogUniform(0.15, 1.5);
    frame.options.sensor.full_well_electrons = random.LogUniform(500, 20000);
    frame.scene.background.kind = kKinds[static_cast<std::size_t>(i) % kKinds.size()];
    frame.scene.background.seed = frame.seed;
    frame.name = "clutter " + std::to_string(i) + " (" + std::string(BackgroundName(frame.scene.background.kind)) +
                 "), seed " + std::to_string(seed);
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace chequer::test
