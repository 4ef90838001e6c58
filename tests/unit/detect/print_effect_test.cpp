// Prints that are not what was sent to the printer: whether poses are exact where it is known how they differ, and say
// how far they may be off where it is not.
#include "detect/pose/print_effect.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "simulate/print_quality.h"
#include "simulate/random.h"
#include "support/pose_errors.h"
#include "support/scenes.h"

namespace chequer {
namespace {

const MarkerCode kSecded({6, 6}, Variant::kSecded);
constexpr double kSideM = 0.08, kDistanceM = 1.2, kFocalPx = 990;  // cells of 11 px

/// What a camera sees of four prints that lie beside each other, tilted by up to 30°.
test::KnownFrame FourPrints(const PrintQuality& quality, std::uint64_t seed) {
  Random random(seed);
  test::KnownFrame frame;
  frame.seed = seed;
  frame.options.camera = test::PlainCamera(640, 480, kFocalPx);
  for (int i = 0; i < 4; ++i) {
    const double x = (i % 2 * 2 - 1) * 0.16 + random.Uniform(-0.05, 0.05), y = (i / 2 * 2 - 1) * 0.13;
    const double heading = random.Uniform(0, 2 * M_PI), tilt = random.Uniform(0, 0.5),
                 axis = random.Uniform(0, 2 * M_PI);
    SceneMarker marker = test::MarkerOf(kSecded, static_cast<std::uint64_t>(random.Below(2048)),
                                        FacingPose({x, y, kDistanceM}, heading, tilt, axis), kSideM);
    marker.margin_cells = 1;
    Print(quality, random.Bits(), marker);
    frame.scene.markers.push_back(std::move(marker));
  }
  return frame;
}

struct Errors {
  test::PoseErrors normalised;
  double depth_square = 0;
  int poor = 0;
};

/// Of the poses in so many frames. @param printed_m width and height that the detector knows of; zeros: the side.
Errors ErrorsOf(const PrintQuality& quality, const PrintTolerance& tolerance, int frames,
                const Eigen::Vector2d& printed_m = Eigen::Vector2d::Zero()) {
  Errors errors;
  for (std::uint64_t seed = 500; seed < 500 + static_cast<std::uint64_t>(frames); ++seed) {
    const test::KnownFrame frame = FourPrints(quality, seed);
    DetectorOptions options;
    options.camera = frame.options.camera;
    options.families = {{.code = kSecded, .side_m = kSideM, .roster = {}}};
    if (!printed_m.isZero()) {
      EXPECT_TRUE(options.families[0].SetPrinted(printed_m));
    }
    options.print_tolerance = tolerance;
    const Image image = frame.Draw();
    for (const MarkerPose& found : Detector(options).Detect(image.view()))
      for (const SceneMarker& marker : frame.scene.markers) {
        if ((CenterPx(marker, frame.options.camera) - found.center_px).norm() > 20) continue;
        errors.normalised.Add(marker.camera_from_marker, found);
        const double off = found.camera_from_marker.translation.z() - marker.camera_from_marker.translation.z();
        errors.depth_square += off * off;
        errors.poor += found.Has(Warning::kPoorFit);
      }
  }
  EXPECT_EQ(errors.normalised.poses(), 4 * frames);
  errors.depth_square /= errors.normalised.poses();
  return errors;
}

TEST(PrintTolerance, PosesOfPrintsWithinItAreHonest) {
  const Errors errors = ErrorsOf({.scale_deviation = 0.0025, .register_m = 3e-5}, kOfficePrints, 12);
  // Few numbers a print make the errors of six: those of 48 prints average 1 ± 0.3, by trials.
  for (const double mean : {errors.normalised.position(), errors.normalised.orientation()}) {
    EXPECT_GT(mean, 0.4);
    EXPECT_LT(mean, 1.5);
  }
  EXPECT_EQ(errors.poor, 0);
}

TEST(PrintTolerance, WithoutItPosesSayThatTheyFitPoorly) {
  PrintQuality stretched;
  stretched.scale = {1.01, 1};
  const Errors errors = ErrorsOf(stretched, {}, 4);
  EXPECT_GE(errors.poor, 12);
  const Errors known = ErrorsOf(stretched, {}, 4, kSideM * stretched.scale);
  EXPECT_EQ(known.poor, 0);
  EXPECT_LT(known.depth_square, 0.02 * errors.depth_square) << "where width and height are known, it is a print as any";
  EXPECT_LT(known.normalised.position(), 2);
  EXPECT_LT(known.normalised.orientation(), 2);
}

TEST(PrintEffect, InformationIsWidenedByTheColumns) {
  BoardGeometry::Information root = BoardGeometry::Information::Random();
  const BoardGeometry::Information information = root * root.transpose() + BoardGeometry::Information::Identity();
  const PrintColumns columns = PrintColumns::Random();
  const BoardGeometry::Information covariance = information.inverse() + columns * columns.transpose();
  EXPECT_TRUE((Widened(information, columns) * covariance).isIdentity(1e-9));
}

TEST(PrintEffect, IsTheDerivativeByWidthAndHeight) {
  Eigen::Matrix3d h;
  h << 60, 5, 300, -4, 55, 200, 0.003, -0.002, 1;
  const BoardGeometry geometry(h), wider(h * Eigen::Vector3d(1.001, 1, 1).asDiagonal());
  const std::vector<std::uint8_t> saturated(36, 0);
  const PrintColumns columns = HomographyByPrint(geometry, {6, 6}, saturated, {.scale = 0.001}, {0.01, 0.01});
  EXPECT_TRUE(columns.col(0).isApprox(wider.parameters() - geometry.parameters(), 1e-9));
  EXPECT_TRUE(columns.rightCols<2>().isZero());
}

TEST(PrintEffect, WhereAllDarkCellsAreBlueTheBoardGoesWithThem) {
  Eigen::Matrix3d h;
  h << 60, 5, 300, -4, 55, 200, 0.003, -0.002, 1;
  const BoardGeometry geometry(h);
  const std::vector<std::uint8_t> saturated(36, 1);
  // A hundredth of a cell: the print's point x lies where the pattern has x + 0.01.
  const PrintColumns columns = HomographyByPrint(geometry, {6, 6}, saturated, {.register_m = 1e-4}, {0.01, 0.01});
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
  shift(0, 2) = 1e-5;
  const BoardGeometry moved(h * shift);
  EXPECT_TRUE((columns.col(2) * 1e-3).isApprox(moved.parameters() - geometry.parameters(), 1e-4));
}

}  // namespace
}  // namespace chequer
