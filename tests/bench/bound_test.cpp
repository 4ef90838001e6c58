#include "bench/bound.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

namespace chequer::bench {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

/// Cells of 8 px, focal length 1000 px, 2 m away on the optical axis (beside it, errors of the depth move the centre),
/// white noise of 0.02 of the contrast.
struct Known {
  SceneMarker marker;
  RenderOptions options;
};
Known EightPixels(double tilt_deg) {
  Known known;
  known.marker.board = MakeBoard(MarkerCode({6, 6}, Variant::kSecded), 1234);
  known.marker.side_m = 0.096;
  known.marker.inks = {Eigen::Vector3f::Constant(0.3f), Eigen::Vector3f::Constant(0.8f),
                       Eigen::Vector3f::Constant(0.3f), Eigen::Vector3f::Constant(0.8f)};
  known.marker.camera_from_marker = FacingPose({0.0004, 0.0003, 2}, 0.4, tilt_deg * kRadians, 1.0);
  known.options.camera = {.width = 200, .height = 160, .fx = 1000, .fy = 1000, .cx = 99.5, .cy = 79.5};
  // A Gaussian that makes 0.8 px with the pixel's own box.
  known.options.blur_sigma_px = std::sqrt(0.64 - 1.0 / 12);
  known.options.tone_curve = ToneCurve::Linear();
  // Contrast 0.5, noise 0.01: read-out of 10,000 electrons in a well of a million leaves nothing else to speak of.
  known.options.sensor.full_well_electrons = 1e6;
  known.options.sensor.read_noise_electrons = 1e4;
  return known;
}

TEST(Bound, IsThatOfTheClosedForm) {
  // Straight edges, free levels and blur, tilted by 10 degrees: centre 0.0025 px, depth 2.3e-4, turn in the plane 0.010
  // degrees, for one sample a pixel. Three of as much less weight are the same.
  Known known = EightPixels(10);
  known.options.sensor.kind = SensorKind::kPerfect;
  known.options.sensor.read_noise_electrons *= std::sqrt(3.0);
  const Matrix6d bound = PoseBound(known.marker, known.options);
  const double px = 1000.0 / 2.0;
  EXPECT_NEAR(std::sqrt((bound(0, 0) + bound(1, 1)) / 2) * px, 0.0025, 0.0003);
  EXPECT_NEAR(std::sqrt(bound(2, 2)) / 2, 2.3e-4, 0.35e-4);
  EXPECT_NEAR(std::sqrt(bound(5, 5)) / kRadians, 0.010, 0.002);
}

TEST(Bound, ScalesWithTheNoise) {
  Known known = EightPixels(20);
  const Matrix6d one = PoseBound(known.marker, known.options);
  known.options.sensor.read_noise_electrons *= 2;
  const Matrix6d two = PoseBound(known.marker, known.options);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(std::sqrt(two(i, i) / one(i, i)), 2, 0.03) << i;
}

TEST(Bound, ThreeSamplesAPixelTellMoreThanOne) {
  Known known = EightPixels(20);
  const Matrix6d mosaic = PoseBound(known.marker, known.options);
  known.options.sensor.kind = SensorKind::kPerfect;
  const Matrix6d perfect = PoseBound(known.marker, known.options);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(std::sqrt(mosaic(i, i) / perfect(i, i)), std::sqrt(3.0), 0.2) << i;
}

TEST(Bound, KnownLevelsAndBlurLeaveLessUnknown) {
  const Known known = EightPixels(20);
  const PoseBounds bounds = PoseBoundsOf(known.marker, known.options);
  EXPECT_TRUE(bounds.alone.isApprox(PoseBound(known.marker, known.options)));
  // What is known can take nothing away: the difference has no negative eigenvalue, in units of the bound itself.
  const Eigen::LLT<Matrix6d> factor(bounds.alone);
  const Matrix6d left = factor.matrixL().solve(Matrix6d(factor.matrixL().solve(bounds.levels_known)).transpose());
  const Eigen::Matrix<double, 6, 1> shares = Eigen::SelfAdjointEigenSolver<Matrix6d>(left).eigenvalues();
  EXPECT_GT(shares.minCoeff(), 0.5);
  EXPECT_LT(shares.maxCoeff(), 1 + 1e-6);
  EXPECT_LT(shares.minCoeff(), 0.95);
}

TEST(Bound, KnownLevelsTellNextToNothingOfLargeSharpCells) {
  // Their pixels tell the levels where no edge is, and the edges' width where the levels are known by then.
  const auto known_over_alone = [](double side_m, double blur_px) {
    Known known = EightPixels(20);
    known.marker.side_m = side_m;
    known.options.blur_sigma_px = blur_px;
    const PoseBounds bounds = PoseBoundsOf(known.marker, known.options);
    return std::sqrt(bounds.levels_known(2, 2) / bounds.alone(2, 2));
  };
  EXPECT_GT(known_over_alone(0.24, 0.4), 0.97);  // cells of 20 px
  EXPECT_LT(known_over_alone(0.048, 1.0), 0.8);  // of 4 px
}

TEST(Bound, AFittedTrackTakesUpItsShareOfTheErrors) {
  // Equal errors of a millimetre and a degree along each axis; n poses leave (n − 2)/n across a line, (n − 1)/n.
  std::vector<RigidTransform> truth;
  for (int i = 0; i < 10; ++i) truth.push_back({Eigen::Quaterniond::Identity(), {0.1 * i, 0, 1}});
  Matrix6d covariance = Matrix6d::Identity() * 1e-6;
  covariance.bottomRightCorner<3, 3>() = Eigen::Matrix3d::Identity() * kRadians * kRadians;
  const std::vector<Matrix6d> covariances(10, covariance);
  const ErrorBound bound = BoundOfTrack(truth, covariances);
  EXPECT_NEAR(bound.position_rms_mm, std::sqrt(3.0), 1e-9);
  EXPECT_NEAR(bound.angle_rms_deg, std::sqrt(3.0), 1e-9);
  EXPECT_NEAR(bound.track.linear_rms_mm, std::sqrt(2 * 0.8), 1e-9);
  EXPECT_NEAR(bound.track.angular_rms_deg, std::sqrt(3 * 0.9), 1e-9);
}

}  // namespace
}  // namespace chequer::bench
