#include "detect/fit/bent_paper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "chequer/detector.h"
#include "simulate/random.h"
#include "simulate/render.h"
#include "support/pose_errors.h"

namespace chequer {
namespace {

const CameraModel kCamera{.width = 640, .height = 480, .fx = 990, .fy = 990, .cx = 319.5, .cy = 239.5};

/// Four boards of 80 mm, their paper on cylinders of that radius, metres; none if it is 0.
std::vector<SceneMarker> Boards(double radius_m, std::uint64_t seed) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  Random random(400 + seed);
  std::vector<SceneMarker> boards;
  for (int i = 0; i < 4; ++i) {
    SceneMarker board;
    const double tilt = random.Uniform(0.1, 0.7), axis = random.Uniform(0, 2 * std::numbers::pi);
    const Eigen::Vector3d at(i % 2 == 0 ? -0.15 : 0.16, i / 2 == 0 ? -0.13 : 0.12, random.Uniform(1.15, 1.25));
    board.camera_from_marker = FacingPose(at, random.Uniform(0, 2 * std::numbers::pi), tilt, axis);
    board.board = MakeBoard(code, random.Bits() % (code.max_id() + 1));
    board.side_m = 0.08;
    board.bend_angle_rad = random.Uniform(0, std::numbers::pi);
    if (radius_m > 0) board.bend_per_m = (i % 2 == 0 ? 1 : -1) / radius_m;
    boards.push_back(board);
  }
  return boards;
}

struct Outcome {
  double depth_mm = 0, squared_errors = 0;
  int found = 0, flipped = 0;
};

Outcome Measure(double radius_m, int frames) {
  DetectorOptions options;
  options.families = {{.code = MarkerCode({6, 6}, Variant::kSecded), .side_m = 0.08, .roster = {}}};
  options.camera = kCamera;
  Detector detector(options);
  RenderOptions render;
  render.camera = kCamera;
  Outcome outcome;
  test::PoseErrors errors;
  double square = 0;
  for (int frame = 0; frame < frames; ++frame) {
    const auto seed = static_cast<std::uint64_t>(frame);
    const std::vector<SceneMarker> boards = Boards(radius_m, seed);
    const Image image = Render({boards, Background{}}, render, seed);
    for (const MarkerPose& pose : detector.Detect(image.view())) {
      for (const SceneMarker& board : boards) {
        const RigidTransform& truth = board.camera_from_marker;
        if (!pose.id || *pose.id != board.board.id) continue;
        ++outcome.found;
        errors.Add(truth, pose);
        square += std::pow(1e3 * (pose.camera_from_marker.translation - truth.translation).z(), 2);
        outcome.flipped += truth.rotation.angularDistance(pose.camera_from_marker.rotation) > 0.1;
      }
    }
  }
  outcome.depth_mm = std::sqrt(square / std::max(outcome.found, 1));
  outcome.squared_errors = (errors.position() + errors.orientation()) / 2;
  return outcome;
}

TEST(BentPaper, IsFittedWhereCornersShowIt) {
  // Without a bend in the model, the depth is 0.18 and 0.35 mm off, and squared errors are 4 to 6.
  const Outcome gently = Measure(2, 12), more = Measure(1, 12);
  EXPECT_EQ(gently.found, 48);
  EXPECT_EQ(more.found, 48);
  EXPECT_LT(gently.depth_mm, 0.12);
  EXPECT_LT(more.depth_mm, 0.2);
  EXPECT_LT(gently.squared_errors, 2);
  EXPECT_LT(more.squared_errors, 2.5);
  EXPECT_EQ(gently.flipped + more.flipped, 0);
}

TEST(BentPaper, IsNotFoundInFlatPaper) {
  const Outcome flat = Measure(0, 12);
  EXPECT_EQ(flat.found, 48);
  EXPECT_LT(flat.depth_mm, 0.1);
  EXPECT_LT(flat.squared_errors, 1.4);
}

/// Corners of a board on a cylinder, seen at an angle.
TEST(FindBentPaper, FindsTheCylinderThatCornersShow) {
  Eigen::Matrix3d h;
  h << 10, 1, 30, -1, 8, -20, 0.0008, 0.0015, 1;
  const BoardGeometry flat(h);
  constexpr double kFocal = 990, kCurvature = 0.02;
  BentPaper truth;
  truth.bend = Eigen::Vector3d(0.64, 0.96, 0.36) * kCurvature / 2;  // along (0.8, 0.6)
  std::vector<CornerOff> corners;
  for (int row = 0; row < 5; ++row)
    for (int col = 0; col < 5; ++col) {
      CornerOff corner;
      corner.board = CornerOnBoard({6, 6}, row, col);
      corner.shift = -truth.BentAt(flat, kFocal, corner.board);
      corner.information = 1e8 * Eigen::Matrix2d::Identity();
      corners.push_back(corner);
    }
  const auto found = FindBentPaper(flat, kFocal, corners);
  ASSERT_TRUE(found);
  EXPECT_LT((found->bend - truth.bend).norm(), 0.05 * truth.bend.norm()) << found->bend.transpose();
  EXPECT_GT(found->gain, 100 * std::max(found->left, 1.0));
  // What the fit has already is found again.
  for (CornerOff& corner : corners) corner.bent = -std::exchange(corner.shift, Eigen::Vector2d::Zero());
  const auto again = FindBentPaper(flat, kFocal, corners);
  ASSERT_TRUE(again);
  EXPECT_LT((again->bend - found->bend).norm(), 1e-9);
}

}  // namespace
}  // namespace chequer
