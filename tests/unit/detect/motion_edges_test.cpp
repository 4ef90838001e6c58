// Edges and corners that a board's motion blurs, as the plain kernel has them.
#include "detect/fit/motion_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "detect/common/normal_integral.h"
#include "support/edge_terms.h"
#include "support/pose_errors.h"
#include "support/stress_frames.h"

namespace chequer {
namespace {

constexpr double kLensPx = 0.6;

/// The mean light of a quadrant right of x and below y, px, over the way of what goes by, behind a lens of kLensPx.
/// @param turn of the way's direction, across its points: the rest of the board goes (−turn · y, turn · x) farther.
double OfQuadrant(const Eigen::Vector2d& way_px, double turn, double x, double y) {
  constexpr int kParts = 200;
  double light = 0;
  for (int i = 0; i < kParts; ++i) {
    const double share = (i + 0.5) / kParts - 0.5;
    light += NormalIntegral((x - share * (way_px.x() - turn * y)) / kLensPx) *
             NormalIntegral((y - share * (way_px.y() + turn * x)) / kLensPx);
  }
  return light / kParts;
}

/// A way over a board whose axes are the image's.
struct Moved {
  Moved(const Eigen::Vector2d& way_px, double turn)
      : shape{way_px, turn},
        fit(shape, Eigen::Matrix2d::Identity(), shape.BlurPx(kLensPx)),
        blur(fit.At(WayByTurn<double>{0, 0})),
        deviation_px(shape.BlurPx(kLensPx) * Eigen::Vector2d(blur.wider_x, blur.wider_y)) {}

  /// As the header of the kernel states it.
  double OfKernel(const KernelInput& input, double x, double y) const {
    double a = x / deviation_px.x(), b = y / deviation_px.y();
    const double product = a * b;
    a += double{input.narrower_x} * product, b += double{input.narrower_y} * product;
    const CornerExcess& corner = input.corner;
    const double correlation = blur.skew + double{corner.moved_x} * (a * a - 1) + double{corner.moved_y} * (b * b - 1) +
                               double{corner.moved_product} * a * b;
    return test::LightOf(input.edge_x, a) * test::LightOf(input.edge_y, b) +
           correlation * std::exp(-0.5 * (a * a + b * b)) / (2 * std::numbers::pi);
  }
  double MostOff(const KernelInput& input) const {
    double most = 0;
    for (double x = -5; x <= 5; x += 0.25)
      for (double y = -5; y <= 5; y += 0.25)
        most = std::max(most, std::abs(OfKernel(input, x, y) - OfQuadrant(shape.way_px, shape.turn, x, y)));
    return most;
  }

  BlurShape shape;
  BlurShapeFit fit;
  CornerBlur<double> blur;
  Eigen::Vector2d deviation_px;
};

TEST(MotionEdges, AreThoseOfWhatGoesByEvenly) {
  for (const auto& [way_px, most] : {std::pair{Eigen::Vector2d(1.5, 0), 1e-3},
                                     {Eigen::Vector2d(3, 0), 2e-3},
                                     {Eigen::Vector2d(0, 4), 2e-3},
                                     {Eigen::Vector2d(1.5, 1), 1.5e-3},
                                     {Eigen::Vector2d(2, -2), 4e-3},
                                     {Eigen::Vector2d(3, 2.5), 1e-2}}) {
    const Moved moved(way_px, 0);
    KernelInput input;
    const double gaussian = moved.MostOff(input);
    AddMotion(moved.fit.InMiddle(), input);
    EXPECT_LT(moved.MostOff(input), most) << way_px.transpose() << ": a Gaussian is off by " << gaussian;
    EXPECT_LT(moved.MostOff(input), 0.4 * gaussian) << way_px.transpose();
  }
}

TEST(MotionEdges, BlurUnevenlyAlongThemselvesWhereABoardTurns) {
  for (const auto& [way_px, turn] : {std::pair{Eigen::Vector2d(3, 0), 0.05},
                                     {Eigen::Vector2d(0, 2.5), 0.05},
                                     {Eigen::Vector2d(2, 1.5), -0.05},
                                     {Eigen::Vector2d(-1, 2), 0.03}}) {
    const Moved moved(way_px, turn);
    KernelInput even;
    AddMotion(moved.fit.InMiddle(), even);
    const KernelInput uneven = even;
    even.narrower_x = even.narrower_y = 0;
    EXPECT_LT(moved.MostOff(uneven), 0.6 * moved.MostOff(even)) << way_px.transpose() << ", " << turn;
  }
}

TEST(MotionEdges, OfShortWaysAreLeftAlone) {
  const Moved moved({0.3, 0.2}, 0.05);
  KernelInput input;
  input.narrower_x = 1;  // of another board
  AddMotion(moved.fit.InMiddle(), input);
  EXPECT_EQ(input.edge_x.by_power, EdgeTerms{}.by_power);
  EXPECT_TRUE(input.corner.none());
  EXPECT_EQ(input.narrower_x, 0);
}

TEST(MotionEdges, LeaveThatOfTheLensWhereTheWayHasNoShare) {
  KernelInput input;
  input.edge_x.by_power[2] += 0.1f;
  input.edge_y.by_power[2] += 0.1f;
  input.corner.square = 0.1f;
  const KernelInput of_lens = input;
  AddMotion({.share_x = 0.5}, input);
  EXPECT_EQ(input.edge_y.by_power, of_lens.edge_y.by_power) << "nothing goes across it";
  EXPECT_NE(input.edge_x.by_power, of_lens.edge_x.by_power);
  EXPECT_FLOAT_EQ(input.corner.square, 0.05f);
}

/// Cells of so many pixels, which go so many while the shutter is open.
struct Way {
  double cell_px, way_px;
  double most_mm;  ///< RMS of positions, as far from the camera as that makes them
  double dot_gain_cells = 0;
  double margin_cells = 0;
};
void PrintTo(const Way& way, std::ostream* out) {
  *out << way.way_px << " px, cells of " << way.cell_px << " px, dot gain " << way.dot_gain_cells << ", margin "
       << way.margin_cells;
}

/// Its board in the middle of the image, as far away as its cells' size has it, and moving by so much.
StressCase CaseOf(const Way& way, const MarkerCode& code, std::uint64_t seed) {
  StressCase stress = test::CaseOf("side_px=48", code, seed);
  const double side_m = stress.scene.markers[0].side_m;
  Eigen::Vector3d& at = stress.scene.markers[0].camera_from_marker.translation;
  at = {0.1 * at.x(), 0.1 * at.y(), stress.options.camera.fx * side_m / (6 * way.cell_px)};
  stress.scene.markers[0].ink_spread_cells = way.dot_gain_cells;
  stress.scene.markers[0].margin_cells = way.margin_cells;
  stress.options.motion_px = way.way_px;
  stress.options.motion_angle_rad = 2.4 * static_cast<double>(seed);
  return stress;
}

class MovedBoards : public testing::TestWithParam<Way> {};

TEST_P(MovedBoards, LieAsExactlyAsTheirPixelsTell) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  test::PoseErrors errors;
  double square = 0;
  for (std::uint64_t seed = 1; seed <= 25; ++seed) {
    const StressCase stress = CaseOf(GetParam(), code, seed);
    const SceneMarker& marker = stress.scene.markers[0];
    for (const MarkerPose& found : test::Look(stress, code, seed)) {
      errors.Add(marker.camera_from_marker, found);
      square += (found.camera_from_marker.translation - marker.camera_from_marker.translation).squaredNorm();
    }
  }
  ASSERT_EQ(errors.poses(), 25);
  EXPECT_LT(1e3 * std::sqrt(square / errors.poses()), GetParam().most_mm);
  EXPECT_LT(errors.position(), 1.5);
  EXPECT_LT(errors.orientation(), 1.5);
}

// Before the way was a box, and motion was looked for where the blur had a shape: 2.35, 1.85, .35 and .089 mm.
INSTANTIATE_TEST_SUITE_P(Ways, MovedBoards,
                         testing::Values(Way{6, 3, 1.0}, Way{8, 4, 0.5}, Way{8, 3, 0.31}, Way{16, 6, 0.07}));
// Before a motion was tried beside a dot gain, and the reverse: 1.3, 4.2 and .85 mm of 60 boards, .14, .23 and .10 now.
INSTANTIATE_TEST_SUITE_P(Prints, MovedBoards,
                         testing::Values(Way{10, 4, 0.2, 0.06}, Way{10, 8, 0.3, 0.06}, Way{16, 5, 0.13, 0.03}));
// As most prints are, moving and standing, and strong ones of large cells. Before the plain model had a dot gain, 1.0,
// .26, .97 and .60 mm of 60 boards; .24, .10, .48 and .003 now.
INSTANTIATE_TEST_SUITE_P(Gains, MovedBoards,
                         testing::Values(Way{10, 8, 0.3, 0.02}, Way{10, 0, 0.13, 0.005}, Way{6, 0, 0.6, 0.01},
                                         Way{40, 0, 0.006, 0.04}));
// As chequer print makes them. Before the light beside a board was looked up in the middle of its margin, .49 and .23
// mm; .24 and .15 now.
INSTANTIATE_TEST_SUITE_P(Margins, MovedBoards, testing::Values(Way{10, 8, 0.3, 0, 1}, Way{16, 10, 0.17, 0, 1}));

/// Boards that move by more than a cell, of which some seemed to move otherwise, or to be hidden in part, or in light
/// that falls off: of such, fits with too short a way came to rest at 10 to 35 squares of the standard deviation, with
/// cells that did not seem to show at 0 to 25 corners, with a cell of the wrong ink at 63 squares.
struct LongWay {
  double way_px;
  std::vector<std::uint64_t> seeds;
};
void PrintTo(const LongWay& way, std::ostream* out) { *out << way.way_px << " px"; }

class LongWays : public testing::TestWithParam<LongWay> {};

TEST_P(LongWays, AreFoundAndShowTheWholeBoard) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  for (const std::uint64_t seed : GetParam().seeds) {
    const StressCase stress = CaseOf({10, GetParam().way_px, 0}, code, seed);
    const std::vector<MarkerPose> found = test::Look(stress, code, seed);
    ASSERT_EQ(found.size(), 1) << "seed " << seed;
    test::PoseErrors errors;
    errors.Add(stress.scene.markers[0].camera_from_marker, found[0]);
    EXPECT_LT(errors.position(), 4) << "seed " << seed;
    EXPECT_EQ(found[0].corners_used, 25) << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(OfACellAndMore, LongWays,
                         testing::Values(LongWay{10, {80, 114, 133}}, LongWay{12, {13, 27, 89, 98}},
                                         LongWay{13, {24, 27, 68, 96, 149}}, LongWay{14, {17, 24, 38, 68}}));

}  // namespace
}  // namespace chequer
