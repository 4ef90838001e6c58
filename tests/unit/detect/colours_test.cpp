#include "detect/common/colours.h"

#include <gtest/gtest.h>

namespace chequer {
namespace {

const Eigen::Vector3f kWhite(0.8f, 0.8f, 0.8f);

TEST(ColourOf, InkSaturatesBothClassesUnderAnyWhite) {
  const Eigen::Vector3f black(0.03f, 0.03f, 0.03f), blue(0.04f, 0.06f, 0.35f), yellow(0.75f, 0.65f, 0.06f);
  for (const Eigen::Vector3f& cast : {Eigen::Vector3f(1, 1, 1), Eigen::Vector3f(1.4f, 1, 0.7f)}) {
    const Eigen::Vector3f white = kWhite.cwiseProduct(cast);
    const auto saturation = [&](const Eigen::Vector3f& light, bool dark) {
      return ColourOf(light.cwiseProduct(cast), white, dark, ColorSpace::kLab).saturation;
    };
    EXPECT_NEAR(saturation(kWhite, false), 0, 1e-3);
    EXPECT_NEAR(saturation(black, true), 0, 1e-3);
    EXPECT_GT(saturation(yellow, false), 40);
    EXPECT_GT(saturation(blue, true), 40);
  }
}

TEST(ColourOf, LabHasCiesLightness) {
  EXPECT_NEAR(ColourOf(kWhite, kWhite, false, ColorSpace::kLab).luminance, 100, 0.01);
  EXPECT_NEAR(ColourOf(0.184187f * kWhite, kWhite, false, ColorSpace::kLab).luminance, 50, 0.01);  // CIE 1976
}

TEST(ColourOf, HsvTakesTheLargestChannelAndItsDistanceToTheSmallest) {
  const CellColour colour = ColourOf(0.8f * Eigen::Vector3f(1, 1, 0), kWhite, false, ColorSpace::kHsv);
  EXPECT_NEAR(colour.luminance, 100, 0.01);
  EXPECT_NEAR(colour.saturation, 100, 0.01);
}

TEST(Overlap, IsTheTailBeyondThePointBetween) {
  EXPECT_NEAR(Overlap({10, 0, 1}, {10, 4, 1}), 0.0227501, 1e-6);  // Φ(−2)
  EXPECT_NEAR(Overlap({10, 4, 3}, {10, 0, 1}), 0.1586553, 1e-6);  // Φ(−1)
  EXPECT_EQ(Overlap({10, 1, 0}, {10, 1, 0}), 0.5);
  EXPECT_EQ(Overlap({10, 1, 0}, {10, 2, 0}), 0);
}

TEST(GaussianSum, HasTheSampleDeviation) {
  GaussianSum sum;
  for (const double value : {2.0, 4.0, 4.0, 6.0}) sum.Add(value);
  EXPECT_EQ(sum.Get().count, 4);
  EXPECT_DOUBLE_EQ(sum.Get().mean, 4);
  EXPECT_DOUBLE_EQ(sum.Get().deviation, std::sqrt(8.0 / 3));
}

}  // namespace
}  // namespace chequer
