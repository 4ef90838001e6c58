#include "simulate/scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "simulate/layouts.h"

namespace chequer {
namespace {

SceneMarker Marker(const RigidTransform& pose) {
  SceneMarker marker;
  marker.board = MakeBoard(MarkerCode(MarkerSize{}, Variant::kSecded), 17);
  marker.side_m = 0.12;
  marker.camera_from_marker = pose;
  return marker;
}

CameraModel Pinhole() { return {.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240}; }

TEST(FacingPose, StandsUprightAndFacesTheCamera) {
  const SceneMarker marker = Marker(FacingPose({0, 0, 1}, 0));
  const CameraModel camera = Pinhole();
  const auto pixel = [&](double col, double row) {
    return camera.Project(marker.camera_from_marker * marker.PointAt(col, row));
  };
  EXPECT_LT((pixel(0, 0) - Eigen::Vector2d(290, 210)).norm(), 1e-9);
  EXPECT_LT((pixel(6, 0) - Eigen::Vector2d(350, 210)).norm(), 1e-9);
  EXPECT_LT((pixel(0, 6) - Eigen::Vector2d(290, 270)).norm(), 1e-9);
  EXPECT_GE(marker.camera_from_marker.rotation.w(), 0);
}

TEST(FacingPose, HeadingTurnsClockwise) {
  const SceneMarker marker = Marker(FacingPose({0, 0, 1}, M_PI / 2));
  // The top left goes to the top right.
  const Eigen::Vector2d top_left = Pinhole().Project(marker.camera_from_marker * marker.PointAt(0, 0));
  EXPECT_LT((top_left - Eigen::Vector2d(350, 210)).norm(), 1e-9);
}

TEST(FacingPose, TiltLeansTheNormal) {
  for (const double axis : {0.0, 1.0, 2.5}) {
    const RigidTransform pose = FacingPose({0, 0, 1}, 0.7, 0.5, axis);
    const Eigen::Vector3d normal = pose.rotation * Eigen::Vector3d::UnitZ();
    EXPECT_NEAR(-normal.z(), std::cos(0.5), 1e-12);
    EXPECT_NEAR(normal.dot(Eigen::Vector3d(std::cos(axis), std::sin(axis), 0)), 0, 1e-12);
  }
}

TEST(SceneMarker, MirrorExchangesLeftAndRight) {
  SceneMarker marker = Marker(FacingPose({0, 0, 1}, 0));
  const Eigen::Vector3d left = marker.PointAt(0, 2);
  marker.mirrored = true;
  EXPECT_LT((marker.PointAt(6, 2) - left).norm(), 1e-12);
}

TEST(IsDrawable, OnlyWhatIsInFrontAndSeenFromItsFace) {
  const CameraModel camera = Pinhole();
  EXPECT_TRUE(IsDrawable(Marker(FacingPose({0, 0, 1}, 0.3)), camera));
  EXPECT_FALSE(IsDrawable(Marker(FacingPose({0, 0, -1}, 0.3)), camera));
  EXPECT_FALSE(IsDrawable(Marker({Eigen::Quaterniond::Identity(), {0, 0, 1}}), camera)) << "seen from behind";
  EXPECT_FALSE(IsDrawable(Marker(FacingPose({0, 0, 0.02}, 0, 1.4)), camera)) << "a corner behind the camera";
}

TEST(OnBentPaper, KeepsLengthsAlongThePaper) {
  // A quarter of a cylinder along y: what lay there ends as far down as the cylinder's axis, and looks along y.
  const double radius = 0.2, way = radius * M_PI / 2;
  const RigidTransform end = OnBentPaper({0.03, way}, 1 / radius, M_PI / 2);
  EXPECT_LT((end.translation - Eigen::Vector3d(0.03, radius, -radius)).norm(), 1e-12);
  EXPECT_LT((end.rotation * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((end.rotation * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitX()).norm(), 1e-12);
  const RigidTransform hollow = OnBentPaper({0.03, way}, -1 / radius, M_PI / 2);
  EXPECT_LT((hollow.translation - Eigen::Vector3d(0.03, radius, radius)).norm(), 1e-12);
}

TEST(OnBentPaper, PutsAPrintOnTheCylinderOfTheWholeSheet) {
  // A point of a print that lies off the sheet's middle: bent with the sheet, or about the print's own middle.
  const double bend = 1 / 0.3, angle = 0.7;
  const Eigen::Vector2d print(0.05, -0.08), point(0.02, 0.03);
  const Eigen::Vector3d with_sheet = OnBentPaper(print + point, bend, angle).translation;
  const Eigen::Vector3d by_print = OnBentPaper(print, bend, angle) * OnBentPaper(point, bend, angle).translation;
  EXPECT_LT((with_sheet - by_print).norm(), 1e-12);
}

TEST(IsDrawable, NotWherePaperBendsAwayFromTheCamera) {
  SceneMarker marker = Marker(FacingPose({0, 0, 1}, 0, 0.8));
  EXPECT_TRUE(IsDrawable(marker, Pinhole()));
  marker.bend_per_m = 2 / marker.side_m;  // by 1 rad from the middle to each side
  marker.bend_angle_rad = M_PI / 2;
  EXPECT_FALSE(IsDrawable(marker, Pinhole()));
}

TEST(IsDrawable, NotBeyondTheFoldOfTheLens) {
  CameraModel camera = PublicationCamera();
  camera.distortion = {-0.5, 0, 0, 0, 0};  // turns back at r = sqrt(2/3)
  EXPECT_TRUE(IsDrawable(Marker(FacingPose({0.3, 0, 1}, 0)), camera));
  EXPECT_FALSE(IsDrawable(Marker(FacingPose({1.2, 0, 1}, 0)), camera));
}

TEST(SmallestCellPx, IsThePitchOfAFacingMarker) {
  EXPECT_NEAR(SmallestCellPx(Marker(FacingPose({0, 0, 1}, 0.4)), Pinhole()), 10, 1e-9);
}

TEST(SmallestCellPx, ShrinksWithTilt) {
  // The far row of a marker tilted by 60° about x: half the height, and a little less.
  const double pitch = SmallestCellPx(Marker(FacingPose({0, 0, 1}, 0, M_PI / 3)), Pinhole());
  EXPECT_LT(pitch, 5);
  EXPECT_GT(pitch, 4);
}

TEST(Scene, CheckNamesTheMarkerAndTheFault) {
  using ::testing::AllOf;
  using ::testing::HasSubstr;
  Scene scene;
  scene.markers = {Marker(FacingPose({0, 0, 1}, 0)), Marker(FacingPose({0, 0, 1}, 0))};
  EXPECT_EQ(scene.Check(), "");
  scene.markers[1].side_m = -1;
  EXPECT_THAT(scene.Check(), AllOf(HasSubstr("marker 1"), HasSubstr("side_m")));
  scene.markers[1] = scene.markers[0];
  scene.markers[0].ink_spread_cells = 0.5;
  EXPECT_THAT(scene.Check(), AllOf(HasSubstr("marker 0"), HasSubstr("ink_spread_cells")));
  scene.markers[0] = scene.markers[1];
  scene.markers[0].board.cells[3] = 'x';
  EXPECT_THAT(scene.Check(), HasSubstr("K, W, B, Y"));
  scene.markers[0] = scene.markers[1];
  scene.markers[0].ink_spread_cells = 0.1;
  scene.markers[0].board.cells.assign(36, 'W');
  EXPECT_THAT(scene.Check(), HasSubstr("no checkerboard"));
  scene.markers.clear();
  scene.background.kind = BackgroundKind::kImage;
  EXPECT_THAT(scene.Check(), HasSubstr("file"));
}

TEST(InkSet, NamesAreKnownAndPhysical) {
  for (const char* name : {"laser", "inkjet", "matte", "faded", "ideal"}) {
    const auto inks = NamedInks(name);
    ASSERT_TRUE(inks.has_value()) << name;
    EXPECT_EQ(inks->Check(), "");
    EXPECT_THAT(InkNames(), ::testing::HasSubstr(name));
    // What the marker is made for: dark is dark and light is light in red, whatever the saturation.
    EXPECT_LT(std::max(inks->black.x(), inks->blue.x()) * 4, std::min(inks->white.x(), inks->yellow.x())) << name;
  }
  EXPECT_FALSE(NamedInks("crayon").has_value());
}

}  // namespace
}  // namespace chequer
