// Where a board lies that is near to where it is expected.
#include "detect/memory/edge_follow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "chequer/image.h"
#include "support/scenes.h"
#include "support/stress_frames.h"

namespace chequer {
namespace {

const MarkerCode kCode({6, 6}, Variant::kSecded);

/// A case of a camera without distortion.
StressCase CaseOf(const char* tag, std::uint64_t seed) {
  StressCase stress = test::CaseOf(tag, kCode, seed);
  const CameraModel& camera = stress.options.camera;
  stress.options.camera = test::PlainCamera(camera.width, camera.height, camera.fx);
  return stress;
}

/// Board coordinates to its pixels.
Eigen::Matrix3d TruePlace(const StressCase& stress) {
  const SceneMarker& marker = stress.scene.markers[0];
  const Eigen::Matrix3d rotation = marker.camera_from_marker.rotation.toRotationMatrix();
  const double cell = marker.CellSize();
  Eigen::Matrix3d place;
  place << rotation.col(0) * cell, -rotation.col(1) * cell, marker.camera_from_marker.translation;
  const CameraModel& camera = stress.options.camera;
  Eigen::Matrix3d pixels = Eigen::Matrix3d::Identity();
  pixels.diagonal().head<2>() << camera.fx, camera.fy;
  pixels.topRightCorner<2, 1>() << camera.cx, camera.cy;
  place = pixels * place;
  return place / place(2, 2);
}

/// That place, moved and turned in the image about the board's middle.
Eigen::Matrix3d Displaced(const Eigen::Matrix3d& place, const Eigen::Vector2d& by_px, double turn) {
  const Eigen::Vector2d middle = place.col(2).hnormalized();
  Eigen::Matrix3d move = Eigen::Matrix3d::Identity();
  move.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(turn).toRotationMatrix();
  move.topRightCorner<2, 1>() = middle + by_px - move.topLeftCorner<2, 2>() * middle;
  const Eigen::Matrix3d moved = move * place;
  return moved / moved(2, 2);
}

std::optional<Eigen::Matrix3d> Follow(const Image& image, const Eigen::Matrix3d& expected) {
  AnchoredBoard board;
  board.size = kCode.size();
  board.plane_from_board = expected;
  const std::array<float, 256> table = image.view().tone_curve().LinearTable();
  return FollowEdges(board, LightReader(image.view(), table), Lens());
}

/// How far the board's outermost inner corners lie from where they truly are, at most.
double FarthestOffPx(const Eigen::Matrix3d& place, const Eigen::Matrix3d& truth) {
  double farthest = 0;
  for (const double x : {-2.0, 2.0})
    for (const double y : {-2.0, 2.0}) {
      const Eigen::Vector3d corner(x, y, 1);
      farthest = std::max(farthest, ((place * corner).hnormalized() - (truth * corner).hnormalized()).norm());
    }
  return farthest;
}

struct Seen {
  const char* tag;
  PixelFormat format = PixelFormat::kBgr8;
};

class FollowedEdges : public testing::TestWithParam<Seen> {};

TEST_P(FollowedEdges, TellWhereABoardLiesThatTurnedOff) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    StressCase stress = CaseOf(GetParam().tag, seed);
    stress.options.format = GetParam().format;
    const Image image = Render(stress.scene, stress.options, seed);
    const Eigen::Matrix3d truth = TruePlace(stress);
    for (const auto& [x, y, turn] : {std::array{1.2, -0.5, 0.0}, {-0.4, 1.3, 0.01}, {0.3, 0.2, -0.02}}) {
      const std::optional<Eigen::Matrix3d> found = Follow(image, Displaced(truth, {x, y}, turn));
      ASSERT_TRUE(found) << "seed " << seed << ", " << x << ", " << y << ", " << turn;
      EXPECT_LT(FarthestOffPx(*found, truth), 0.6) << "seed " << seed << ", " << x << ", " << y << ", " << turn;
    }
    EXPECT_LT(FarthestOffPx(Follow(image, truth).value_or(truth), truth), 0.3) << "as expected, seed " << seed;
    EXPECT_FALSE(Follow(image, Displaced(truth, {6, 6}, 0.1))) << "half a cell off, seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Conditions, FollowedEdges,
                         testing::Values(Seen{"psf_px=1"}, Seen{"psf_px=1", PixelFormat::kMono8},
                                         Seen{"psf_px=1", PixelFormat::kBayerRg8}, Seen{"jpeg=75"},
                                         Seen{"ink_spread=0.05"}, Seen{"tilt_deg=30"}),
                         [](const auto& info) {
                           std::string name =
                               std::string(info.param.tag) + "_" + std::string(PixelFormatName(info.param.format));
                           std::replace_if(
                               name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
                           return name;
                         });

TEST(FollowEdges, LeavesWhatIsNoBoardAndWhatLiesBeyondTheImage) {
  StressCase stress = CaseOf("psf_px=1", 3);
  const Eigen::Matrix3d truth = TruePlace(stress);
  const Image image = Render(stress.scene, stress.options, 1);
  // The address sanitizer would tell.
  for (const double x : {-400.0, 300.0, 1e12, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_FALSE(Follow(image, Displaced(truth, {x, 1}, 0))) << x;
  stress.scene.markers.clear();
  EXPECT_FALSE(Follow(Render(stress.scene, stress.options, 1), Displaced(truth, {1, 0}, 0)));
}

}  // namespace
}  // namespace chequer
