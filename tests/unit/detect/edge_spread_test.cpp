// Edges that are no Gaussian's: a filter of the camera's makes them so.
#include "detect/fit/edge_spread.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "chequer/detector.h"
#include "simulate/stress.h"
#include "support/edge_terms.h"

namespace chequer {
namespace {

/// Every pixel takes up a part of its neighbours, as in a camera that smooths its images.
LinearImage Smoothed(const LinearImage& image, float neighbour) {
  LinearImage smoothed(image.width, image.height);
  const std::array<float, 3> taps{neighbour, 1 - 2 * neighbour, neighbour};
  for (int y = 1; y + 1 < image.height; ++y)
    for (int x = 1; x + 1 < image.width; ++x)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
          for (int c = 0; c < 3; ++c)
            smoothed.Pixel(x, y)[c] += taps[static_cast<std::size_t>(1 + dx)] * taps[static_cast<std::size_t>(1 + dy)] *
                                       image.Pixel(x + dx, y + dy)[c];
  return smoothed;
}

/// Every pixel takes up a sixth of its neighbours; the lens blurs no more.
constexpr double kSixth = 1.0 / 6;
const EdgeSpread kSmoothing{.blur_px = std::sqrt(1.0 / 12 + 2 * kSixth), .filter = 1};

Eigen::Vector2d Slanted(double degrees) {
  const double slant = degrees * std::numbers::pi / 180;
  return {std::cos(slant), std::sin(slant)};
}

double Normal(double deviations) { return 0.5 * std::erfc(-deviations / std::numbers::sqrt2); }

/// The light that a pixel smoothed by sixths receives of a quadrant that is turned by so much about its corner.
double OfQuadrant(double degrees, double right, double down) {
  const Eigen::Vector2d across = Slanted(degrees);
  constexpr int kParts = 20;
  const auto weight = [](double at) { return std::abs(at) < 0.5 ? 1 - 2 * kSixth : kSixth; };
  double light = 0;
  for (int i = 0; i < 3 * kParts; ++i)
    for (int j = 0; j < 3 * kParts; ++j) {
      const double x = (i + 0.5) / kParts - 1.5, y = (j + 0.5) / kParts - 1.5;
      const double u = right + x * across.x() + y * across.y(), v = down - x * across.y() + y * across.x();
      if (u > 0 && v > 0) light += weight(x) * weight(y);
    }
  return light / (kParts * kParts);
}

TEST(EdgeSpread, OfSmoothedPixelsRisesInSteps) {
  // An upright edge's light comes in as the smoothing's three squares pass over it.
  for (const auto& [distance, light] : {std::pair{-1.5, 0.0},
                                        {-1.0, kSixth / 2},
                                        {-0.5, kSixth},
                                        {0.0, 0.5},
                                        {0.25, 0.5 + 0.25 * (1 - 2 * kSixth)},
                                        {1.0, 1 - kSixth / 2},
                                        {2.0, 1.0}})
    EXPECT_NEAR(EdgeProfile(kSmoothing, {-3, 0}, distance), light, 0.01) << distance;
}

TEST(EdgeSpread, OfALensIsAGaussian) {
  for (const double slant : {0.0, 20.0, 45.0})
    for (double a = -4; a <= 4; a += 0.5)
      EXPECT_NEAR(EdgeProfile({.blur_px = 1, .filter = 0}, Slanted(slant), a), Normal(a), 5e-4);
}

TEST(EdgeSpread, TermsAreItsProfile) {
  for (const EdgeSpread& shape : {kSmoothing, EdgeSpread{0.6, 0.5}, EdgeSpread{0.6, -0.5}, EdgeSpread{0.4, 0}})
    for (const double slant : {0.0, 10.0, 20.0, 30.0, 45.0}) {
      const EdgeTerms terms = TermsOf(shape, Slanted(slant));
      for (double a = -4; a <= 4; a += 0.1)
        EXPECT_NEAR(test::LightOf(terms, a), EdgeProfile(shape, Slanted(slant), a * shape.blur_px),
                    slant < 15 ? 0.012 : 0.005)
            << shape.blur_px << ", " << shape.filter << ", " << slant << " degrees, " << a;
    }
}

TEST(EdgeSpread, IsAGaussiansUnlessTold) {
  for (double a = -4; a <= 4; a += 0.1) EXPECT_NEAR(test::LightOf(TermsOf({}, {1, 0}), a), Normal(a), 1e-4);
  EXPECT_TRUE(CornerExcessOf({}, Slanted(20)).none());
}

TEST(EdgeSpread, IsTheSameBetweenNodes) {
  EdgeProfiles profiles;
  profiles.Set(kSmoothing);
  for (double slant = 0; slant < 360; slant += 7) {
    const EdgeTerms between = profiles.Across(Slanted(slant)), exact = TermsOf(kSmoothing, Slanted(slant));
    for (double a = 0; a <= 4; a += 0.25)
      EXPECT_NEAR(test::LightOf(between, a), test::LightOf(exact, a), 1.5e-3) << slant;
  }
  // What was kept is not another shape's.
  profiles.Set({});
  EXPECT_EQ(profiles.Across({1, 0}).by_power, EdgeTerms{}.by_power);
}

TEST(EdgeSpread, CornersHaveMostOfWhatTheirEdgesDoNotTell) {
  for (const double slant : {10.0, 22.0, 40.0, 107.0}) {
    const CornerExcess excess = CornerExcessOf(kSmoothing, Slanted(slant));
    double square = 0, left = 0;
    for (double a = -2.25; a <= 2.5; a += 0.5)
      for (double b = -2.25; b <= 2.5; b += 0.5) {
        const double right = a * kSmoothing.blur_px, down = b * kSmoothing.blur_px;
        const double edges =
            EdgeProfile(kSmoothing, Slanted(slant), right) * EdgeProfile(kSmoothing, Slanted(slant + 90), down);
        const double lacks = OfQuadrant(slant, right, down) - edges, size = a * a + b * b;
        const double has = std::exp(-0.5 * size) / (2 * std::numbers::pi) *
                           (double{excess.square} * (a * a - b * b) + double{excess.product} * a * b) *
                           (1 - double{CornerExcess::kFall} * size);
        square += lacks * lacks;
        left += (lacks - has) * (lacks - has);
      }
    EXPECT_LT(left, 0.4 * square) << slant << " degrees: " << std::sqrt(left / 100) << " of "
                                  << std::sqrt(square / 100);
  }
}

TEST(EdgeSpread, DepthsBehindACamerasFilterAreAsExactAsTheNoiseAllows) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  double square = 0, angle_square = 0;
  int poses = 0;
  for (std::uint64_t seed = 8100; seed < 8112; ++seed) {
    for (StressCase& stress : StressCases(code, seed)) {
      if (stress.tag != "side_px=48") continue;
      stress.options.blur_sigma_px = 0.1;
      const RigidTransform& truth = stress.scene.markers[0].camera_from_marker;
      const Image image = Expose(Smoothed(RenderLight(stress.scene, stress.options), 0.165f), stress.options.sensor,
                                 PixelFormat::kBayerRg8, stress.options.tone_curve, seed);
      DetectorOptions options;
      options.families = {{.code = code, .side_m = stress.scene.markers[0].side_m, .roster = {}}};
      options.camera = stress.options.camera;
      for (const MarkerPose& marker : Detector(options).Detect(image.view())) {
        const double error = marker.camera_from_marker.translation.z() / truth.translation.z() - 1;
        square += error * error;
        const Eigen::Quaterniond turn = truth.rotation * marker.camera_from_marker.rotation.conjugate();
        angle_square += VectorFromRotation(turn.normalized()).squaredNorm();
        ++poses;
      }
    }
  }
  ASSERT_EQ(poses, 12);
  // With edges taken for a Gaussian's it is 1.17e-4.
  EXPECT_LT(std::sqrt(square / poses), 1.0e-4);
  // With the first terms of a series for the edges it is 0.168 degrees, now 0.125.
  EXPECT_LT(std::sqrt(angle_square / poses), 0.15 * std::numbers::pi / 180);
}

}  // namespace
}  // namespace chequer
