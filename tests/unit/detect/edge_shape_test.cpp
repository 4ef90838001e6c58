// Edges that are no Gaussian's: a filter of the camera's makes them so.
#include "detect/edge_shape.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "chequer/detector.h"
#include "simulate/stress.h"

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

TEST(EdgeShape, TermsAreThoseOfHermitesPolynomials) {
  const EdgeTerms terms = TermsOf({0.02, 0.01}, {0, 2});
  for (const float a : {-1.5f, 0.5f, 2.0f}) {
    const float square = a * a;
    EXPECT_NEAR(a * (terms.first + square * (terms.third + square * terms.fifth)),
                0.02f * a * (square - 3) + 0.01f * a * (square * square - 10 * square + 15), 1e-6);
  }
}

TEST(EdgeShape, SlantedEdgesHaveLess) {
  const EdgeTerms upright = TermsOf({0, 0.01}, {1, 0}), slanted = TermsOf({0, 0.01}, {1, -1});
  EXPECT_NEAR(slanted.fifth, upright.fifth / 4, 1e-7);
}

TEST(EdgeShape, DepthsBehindACamerasFilterAreAsExactAsTheNoiseAllows) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  double square = 0;
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
        ++poses;
      }
    }
  }
  ASSERT_EQ(poses, 12);
  // With edges taken for a Gaussian's it is 1.17e-4.
  EXPECT_LT(std::sqrt(square / poses), 1.0e-4);
}

}  // namespace
}  // namespace chequer
