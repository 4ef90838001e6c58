// Boards that the edge of a shadow crosses: cells of two lights, which no level and no gradient describes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "chequer/detector.h"
#include "chequer/tone_curve.h"
#include "simulate/random.h"
#include "simulate/render.h"
#include "support/pose_errors.h"
#include "support/stress_frames.h"

namespace chequer {
namespace {

struct Shadow {
  PixelFormat format;
  const char* tag;  ///< of the stress case that it falls on
  double takes;     ///< of the light
  int frames;
  int read;     ///< of their boards, at least
  double most;  ///< normalised squared errors average, per dimension
};

void PrintTo(const Shadow& shadow, std::ostream* out) {
  *out << shadow.tag << (IsBayer(shadow.format) ? " Bayer" : " BGR") << " less " << shadow.takes;
}

/// Takes that share of the light away on one side of a line, sRGB-coded bytes; its edge is a pixel (σ) wide.
void Cast(double takes, const Eigen::Vector2d& through, double direction, Random& random, Image& image) {
  const std::size_t channels = image.bytes().size() / static_cast<std::size_t>(image.width() * image.height());
  const ToneCurve curve = ToneCurve::Srgb();
  const std::array<float, 256> light = curve.LinearTable();
  std::size_t at = 0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      const double beyond = (x - through.x()) * std::cos(direction) + (y - through.y()) * std::sin(direction);
      const double left = 1 - takes * 0.5 * std::erfc(-beyond / std::numbers::sqrt2);
      std::uint8_t* const pixel = &image.bytes()[at];
      at += channels;
      if (left > 0.999) continue;
      // Dithered, as the noise below a step of the code is gone.
      for (std::size_t c = 0; c < channels; ++c) {
        const double code = 255 * curve.FromLinear(left * light[pixel[c]]) + random.Uniform(-0.5, 0.5);
        pixel[c] = static_cast<std::uint8_t>(std::clamp(std::lround(code), 0l, 255l));
      }
    }
}

class Shadows : public testing::TestWithParam<Shadow> {};

TEST_P(Shadows, CrossBoardsThatAreReadAndHonest) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  test::PoseErrors errors;
  int wrong = 0;
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(GetParam().frames); ++seed) {
    StressCase stress = test::CaseOf(GetParam().tag, code, seed);
    stress.options.format = GetParam().format;
    const SceneMarker& marker = stress.scene.markers[0];
    const RigidTransform& truth = marker.camera_from_marker;
    Image image = Render(stress.scene, stress.options, seed);
    Random random(7000 + seed);
    const double direction = random.Uniform(0, 2 * std::numbers::pi),
                 side_px = stress.options.camera.fx * marker.side_m / truth.translation.z(),
                 off_px = random.Uniform(-0.45, 0.45) * side_px;
    const Eigen::Vector2d through = stress.options.camera.Project(truth.translation) +
                                    off_px * Eigen::Vector2d(std::cos(direction), std::sin(direction));
    Cast(GetParam().takes, through, direction, random, image);
    DetectorOptions options;
    options.families = {{.code = code, .side_m = marker.side_m, .roster = {}}};
    options.camera = stress.options.camera;
    for (const MarkerPose& found : Detector(options).Detect(image.view())) {
      if (!found.id) continue;
      wrong += *found.id != marker.board.id;
      errors.Add(truth, found);
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GE(errors.poses(), GetParam().read);
  EXPECT_LT(errors.position(), GetParam().most);
  EXPECT_LT(errors.orientation(), GetParam().most);
}

INSTANTIATE_TEST_SUITE_P(OfOnePixel, Shadows,
                         testing::Values(Shadow{PixelFormat::kBgr8, "side_px=96", 0.3, 25, 24, 2},
                                         Shadow{PixelFormat::kBgr8, "side_px=96", 0.6, 25, 23, 2},
                                         Shadow{PixelFormat::kBayerRg8, "side_px=96", 0.6, 25, 22, 2},
                                         Shadow{PixelFormat::kBayerRg8, "side_px=48", 0.6, 25, 22, 2},
                                         Shadow{PixelFormat::kBayerRg8, "side_px=48", 0.8, 25, 18, 2}));
/// As many as a sanitizer has time for.
INSTANTIATE_TEST_SUITE_P(Few, Shadows,
                         testing::Values(Shadow{PixelFormat::kBgr8, "side_px=96", 0.6, 4, 3, 3},
                                         Shadow{PixelFormat::kBayerRg8, "side_px=48", 0.6, 4, 3, 3}));

}  // namespace
}  // namespace chequer
