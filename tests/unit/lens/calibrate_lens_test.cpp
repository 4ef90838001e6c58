#include "lens/calibrate_lens.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "core/lens_parameters.h"
#include "support/error_of.h"
#include "synthetic_views.h"

namespace chequer {
namespace {

using test::MakeViews;
using test::TypicalCamera;
using test::ViewPlan;
using ::testing::HasSubstr;
using Kind = CameraModel::Kind;

LensCalibration Calibrate(const std::vector<LensView>& views, const CameraModel& camera) {
  return CalibrateLens(views, {camera.width, camera.height, camera.kind});
}

std::string ErrorOf(const std::vector<LensView>& views, const CameraModel& camera) {
  return test::ErrorOf([&] { Calibrate(views, camera); });
}

/// The largest distance between the pixels in which two cameras see the same points, over the image.
double LargestDifference(const CameraModel& a, const CameraModel& b) {
  double most = 0;
  for (int x = 0; x <= a.width; x += a.width / 16)
    for (int y = 0; y <= a.height; y += a.height / 12)
      if (const auto p = a.Undistort({x, y})) most = std::max(most, (b.Distort(*p) - Eigen::Vector2d(x, y)).norm());
  return most;
}

class CalibrateLensOfKind : public ::testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Models, CalibrateLensOfKind, ::testing::Values(Kind::kBrownConrady, Kind::kFisheye),
                         [](const auto& name) { return name.param == Kind::kFisheye ? "fisheye" : "brown_conrady"; });

TEST_P(CalibrateLensOfKind, FindsALensFromNothingButTheSheet) {
  const CameraModel truth = TypicalCamera(GetParam());
  const LensCalibration found = Calibrate(MakeViews({.camera = truth}), truth);
  EXPECT_NEAR(found.camera.fx / truth.fx, 1, 0.001);
  EXPECT_NEAR(found.camera.fy / truth.fy, 1, 0.001);
  EXPECT_NEAR(found.camera.cx, truth.cx, 1);
  EXPECT_NEAR(found.camera.cy, truth.cy, 1);
  EXPECT_LT(LargestDifference(truth, found.camera), 0.6);
  EXPECT_NEAR(found.record.rms_px, 0.05 * std::sqrt(2), 0.005);
  EXPECT_EQ(found.record.views, 18);
  EXPECT_EQ(found.boards, 6);
  EXPECT_EQ(found.loose_boards, 0);
}

TEST_P(CalibrateLensOfKind, SaysHowExactItIs) {
  const CameraModel truth = TypicalCamera(GetParam());
  double square = 0;
  constexpr int kSeeds = 5;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    LensCalibration found = Calibrate(
        MakeViews({.camera = truth, .count = 14, .board_columns = 2, .seed = static_cast<std::uint64_t>(seed)}), truth);
    CameraModel camera = truth;
    for (int i = 0; i < LensParameterCount(truth.kind); ++i) {
      const double off = LensParameter(found.camera, i) - LensParameter(camera, i);
      EXPECT_NEAR(std::sqrt(found.camera.covariance(i, i)), found.record.uncertainty[static_cast<std::size_t>(i)],
                  1e-9);
      const double score = off / found.record.uncertainty[static_cast<std::size_t>(i)];
      square += score * score / (kSeeds * LensParameterCount(truth.kind));
    }
  }
  // Errors are as large as said, to within what so few calibrations tell.
  EXPECT_GT(std::sqrt(square), 0.6);
  EXPECT_LT(std::sqrt(square), 1.6);
}

TEST(CalibrateLens, HalfVisibleSheetsCount) {
  const CameraModel truth = TypicalCamera(Kind::kBrownConrady);
  std::vector<LensView> views = MakeViews({.camera = truth, .count = 30});
  // Of each view, one of the boards on the left or on the right alone.
  for (std::size_t v = 0; v < views.size(); ++v)
    std::erase_if(views[v].points, [&](const SeenPoint& point) { return (point.board % 3 == 0) == (v % 3 == 0); });
  const LensCalibration found = Calibrate(views, truth);
  EXPECT_NEAR(found.camera.fx / truth.fx, 1, 0.002);
}

TEST(CalibrateLens, LeavesOutBadViewsAndNamesThem) {
  const CameraModel truth = TypicalCamera(Kind::kBrownConrady);
  std::vector<LensView> views = MakeViews({.camera = truth});
  // A view while the sheet was bent, one of somebody else's board, one of nearly nothing.
  for (SeenPoint& point : views[3].points) point.pixel.x() += 4 * std::sin(point.pixel.y() / 30);
  for (std::size_t i = 0; i < views[7].points.size(); ++i)
    views[7].points[i].pixel = {37.0 * double(i % 31), 11.0 * double(i % 83)};
  views[9].points.resize(3);
  // And one board that was misread where it stood.
  std::size_t large = 0;
  for (std::size_t v = 0; v < views.size(); ++v)
    if (views[v].points.size() > views[large].points.size() && v != 3 && v != 7) large = v;
  const int misread = views[large].points[0].board;
  for (SeenPoint& point : views[large].points)
    if (point.board == misread) point.pixel.x() += 9;
  const LensCalibration found = Calibrate(views, truth);
  EXPECT_NEAR(found.camera.fx / truth.fx, 1, 0.001);
  EXPECT_EQ(found.record.views, 15);
  for (const std::size_t bad : {3u, 7u, 9u}) {
    EXPECT_FALSE(found.views[bad].used);
    EXPECT_NE(found.views[bad].why_not, "");
  }
  EXPECT_TRUE(found.views[large].used);
  EXPECT_LT(found.record.rms_px, 0.08);
}

TEST(CalibrateLens, OneBoardIsEnough) {
  const CameraModel truth = TypicalCamera(Kind::kBrownConrady);
  const LensCalibration found = Calibrate(
      MakeViews({.camera = truth, .count = 40, .board_columns = 1, .board_rows = 1, .board_side_m = 0.2}), truth);
  EXPECT_NEAR(found.camera.fx / truth.fx, 1, 0.005);
}

TEST(CalibrateLens, LeavesOutBoardsThatNothingTiesToTheOthers) {
  const CameraModel truth = TypicalCamera(Kind::kBrownConrady);
  std::vector<LensView> views = MakeViews({.camera = truth});
  LensView alone;
  for (LensView& view : views) {
    LensView of_one = view;
    std::erase_if(of_one.points, [](const SeenPoint& point) { return point.board != 3; });
    std::erase_if(view.points, [](const SeenPoint& point) { return point.board == 3; });
    if (of_one.points.size() > alone.points.size()) alone = of_one;
  }
  ASSERT_GT(alone.points.size(), 8u);
  views.push_back(alone);
  const LensCalibration found = Calibrate(views, truth);
  EXPECT_EQ(found.loose_boards, 1);
  EXPECT_FALSE(found.views.back().used);
  EXPECT_NEAR(found.camera.fx / truth.fx, 1, 0.001);
}

TEST(CalibrateLens, SaysWhatIsMissing) {
  const CameraModel truth = TypicalCamera(Kind::kBrownConrady);
  EXPECT_THAT(ErrorOf({}, truth), HasSubstr("0 views"));
  EXPECT_THAT(ErrorOf(MakeViews({.camera = truth, .count = 3}), truth), HasSubstr("3 views"));
  // Never tilted: a longer lens farther away shows the same.
  CameraModel narrow = truth;
  narrow.distortion = {};
  narrow.fx = narrow.fy = 4000;
  EXPECT_THAT(ErrorOf(MakeViews({.camera = narrow, .max_tilt_rad = 0.001, .noise_px = 0.2}), narrow),
              HasSubstr("tilt"));
  // Boards that move on their own are no sheet.
  std::vector<LensView> views = MakeViews({.camera = truth});
  for (std::size_t v = 0; v < views.size(); ++v)
    for (SeenPoint& point : views[v].points)
      point.pixel +=
          60.0 * Eigen::Vector2d(std::sin(double(v) * 3 + point.board), std::cos(double(v) + 5 * point.board));
  EXPECT_THAT(ErrorOf(views, truth), HasSubstr("sheet"));
}

TEST(CalibrateLens, DerivativesAreThoseOfTheProjection) {
  for (const Kind kind : {Kind::kPinhole, Kind::kBrownConrady, Kind::kFisheye}) {
    CameraModel camera = TypicalCamera(kind);
    const Eigen::Vector3d x(0.3, -0.2, 0.9);
    const auto seen = ProjectWithDerivatives(camera, x);
    ASSERT_TRUE(seen.has_value());
    EXPECT_LT((seen->pixel - camera.Project(x)).norm(), 1e-9);
    constexpr double kStep = 1e-6;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d moved = x + kStep * Eigen::Vector3d::Unit(i);
      EXPECT_LT((seen->by_point.col(i) - (camera.Project(moved) - seen->pixel) / kStep).norm(), 0.02);
    }
    for (int i = 0; i < LensParameterCount(kind); ++i) {
      CameraModel moved = camera;
      LensParameter(moved, i) += kStep;
      EXPECT_LT((seen->by_lens.col(i) - (moved.Project(x) - seen->pixel) / kStep).norm(), 1e-3) << i;
    }
  }
  EXPECT_FALSE(ProjectWithDerivatives(TypicalCamera(Kind::kPinhole), {0, 0, -1}).has_value());
}

TEST_P(CalibrateLensOfKind, TellsAPrinterThatStretchesOneDirection) {
  const CameraModel truth = TypicalCamera(GetParam());
  const std::vector<LensView> views = MakeViews({.camera = truth});
  const LensCalibration plain = Calibrate(views, truth);
  EXPECT_FALSE(plain.print.matters()) << plain.print.stretch;
  // What was printed 1 % taller is taken for a target that was meant to be.
  const LensCalibration found = Calibrate(Stretched(views, -0.01), truth);
  EXPECT_NEAR(found.print.stretch, 1 / 0.99 - 1, 4 * found.print.deviation + 2e-4);
  EXPECT_LT(found.print.deviation, 1e-3);
  EXPECT_LT(LargestDifference(truth, found.camera), 0.6);
  EXPECT_NEAR(found.record.rms_px, plain.record.rms_px, 0.002);
}

TEST_P(CalibrateLensOfKind, SeesThatTheSheetBends) {
  const CameraModel truth = TypicalCamera(GetParam());
  // Of a radius of 3 m; taken as flat, the focal length is off by percents.
  for (const double bend_per_m : {1.0 / 3, -1.0 / 3}) {
    const LensCalibration found = Calibrate(MakeViews({.camera = truth, .bend_per_m = bend_per_m}), truth);
    EXPECT_NEAR(found.camera.fx / truth.fx, 1, 0.001);
    EXPECT_NEAR(found.camera.fx, truth.fx, 4 * found.record.uncertainty[0]);
    EXPECT_LT(LargestDifference(truth, found.camera), 0.8);
    EXPECT_NEAR(found.bend.LargestPerM(), 1.0 / 3, 0.02);
    EXPECT_NEAR(found.record.rms_px, 0.05 * std::sqrt(2), 0.005);
  }
}

}  // namespace
}  // namespace chequer
