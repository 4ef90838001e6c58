// Boards in which glossy paper mirrors a lamp: light that is added to all cells alike.
#include <gtest/gtest.h>

#include <vector>

#include "detect/fit/terms.h"
#include "simulate/print_quality.h"
#include "support/pose_errors.h"
#include "support/stress_frames.h"

namespace chequer {
namespace {

struct Mirror {
  PixelFormat format;
  const char* tag;  ///< of the stress case that it lies on
  double gloss;     ///< light at its middle, over white paper's
  double exposure;  ///< 0.5 keeps a gloss of 1 below saturation
  double most;      ///< normalised squared errors, average, per dimension: 4 to 6 without the term
};

void PrintTo(const Mirror& mirror, std::ostream* out) {
  *out << mirror.tag << (IsBayer(mirror.format) ? " Bayer" : " BGR") << " gloss " << mirror.gloss;
}

class Highlights : public testing::TestWithParam<Mirror> {};

TEST_P(Highlights, AreFittedAndPosesHonest) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  constexpr int kFrames = 25;
  test::PoseErrors errors;
  for (std::uint64_t seed = 1; seed <= kFrames; ++seed) {
    StressCase stress = test::CaseOf(GetParam().tag, code, seed);
    stress.options.format = GetParam().format;
    stress.options.sensor.exposure = GetParam().exposure;
    SceneMarker& marker = stress.scene.markers[0];
    Print({.gloss = GetParam().gloss}, 500 + seed, marker);
    for (const MarkerPose& found : test::Look(stress, code, seed)) {
      if (!found.id) continue;
      EXPECT_EQ(*found.id, marker.board.id) << "seed " << seed;
      errors.Add(marker.camera_from_marker, found);
    }
  }
  RecordProperty("position", std::to_string(errors.position()));
  EXPECT_GE(errors.poses(), kFrames - 1);
  EXPECT_LT(errors.position(), GetParam().most) << errors.position();
  EXPECT_LT(errors.orientation(), GetParam().most) << errors.orientation();
}

INSTANTIATE_TEST_SUITE_P(Many, Highlights,
                         testing::Values(Mirror{PixelFormat::kBgr8, "side_px=96", 0.3, 0.5, 1.5},
                                         Mirror{PixelFormat::kBgr8, "side_px=96", 0.7, 0.5, 1.5},
                                         Mirror{PixelFormat::kBayerRg8, "side_px=48", 0.5, 0.5, 1.5}));

/// A board of 6 x 6 cells, every third of which has a colour, in such light.
template <class Light>
std::optional<HighlightTerm> FindIn(const Light& light, double blur = 0.08) {
  constexpr MarkerSize kSize{6, 6};
  std::vector<PhaseValues> levels(36);
  std::vector<std::uint8_t> saturated(36);
  for (int cell = 0; cell < 36; ++cell) {
    const std::size_t i = static_cast<std::size_t>(cell);
    saturated[i] = cell % 3 == 0;
    const float ink = IsDark(cell / 6, cell % 6) ? (saturated[i] ? 0.06f : 0.02f) : (saturated[i] ? 0.38f : 0.4f);
    levels[i].fill(light(ink, MiddleOfCell(kSize, cell)));
  }
  return HighlightTerm::Find({kSize, levels, saturated, 1, blur});
}

TEST(HighlightTerm, IsFoundInCells) {
  HighlightTerm there;
  there.spot = HighlightTerm::Parameters(0.5, 1, -2, std::log(1.2));
  const auto found =
      FindIn([&](float ink, const Eigen::Vector2d& at) { return ink + 0.4f * static_cast<float>(there.At(at)); });
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->spot[HighlightTerm::kX], 1, 0.3);
  EXPECT_NEAR(found->spot[HighlightTerm::kY], -2, 0.3);
  EXPECT_NEAR(found->spot[HighlightTerm::kAmount], 0.5, 0.2);
}

TEST(HighlightTerm, IsNotWhatBlurMixesOfCells) {
  HighlightTerm there;
  there.spot = HighlightTerm::Parameters(0.1, 1, 2, 0.6);
  const auto light = [&](float ink, const Eigen::Vector2d& at) {
    return ink + 0.4f * static_cast<float>(there.At(at));
  };
  EXPECT_TRUE(FindIn(light, 0.08));
  EXPECT_FALSE(FindIn(light, 0.12)) << "a short motion makes dark cells differ as much";
}

TEST(HighlightTerm, IsNoShadowAndNoGradient) {
  EXPECT_FALSE(FindIn([](float ink, const Eigen::Vector2d&) { return ink; }));
  EXPECT_FALSE(FindIn([](float ink, const Eigen::Vector2d& at) { return at.x() > 0.5 ? 0.3f * ink : ink; }));
  EXPECT_FALSE(
      FindIn([](float ink, const Eigen::Vector2d& at) { return ink * static_cast<float>(1 + 0.15 * at.x()); }));
}

}  // namespace
}  // namespace chequer
