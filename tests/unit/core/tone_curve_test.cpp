#include "chequer/tone_curve.h"

#include <gtest/gtest.h>

#include <cmath>

namespace chequer {
namespace {

TEST(ToneCurve, SrgbHasTheStandardsValues) {
  const ToneCurve curve = ToneCurve::Srgb();
  EXPECT_NEAR(curve.ToLinear(0.5), 0.21404114, 1e-7);  // IEC 61966-2-1
  EXPECT_NEAR(curve.ToLinear(0.04), 0.04 / 12.92, 1e-12);
  EXPECT_EQ(curve.ToLinear(1.0), 1.0);
}

TEST(ToneCurve, FromLinearInvertsToLinear) {
  for (const ToneCurve& curve : {ToneCurve::Srgb(), ToneCurve::Linear(), ToneCurve::Gamma(2.2)})
    for (int i = 0; i < 256; ++i) EXPECT_NEAR(curve.FromLinear(curve.ToLinear(i / 255.0)), i / 255.0, 1e-6);
}

TEST(ToneCurve, BendsMoveValuesAndLeaveBlackAndWhite) {
  ToneCurve::Bends bends{0.02f, 0.04f, 0.05f, 0.05f, 0.04f, 0.02f, 0.01f};
  for (const ToneCurve& base : {ToneCurve::Srgb(), ToneCurve::Gamma(1.4)}) {
    const auto bent = base.WithBends(bends);
    ASSERT_TRUE(bent);
    EXPECT_EQ(bent->ToLinear(0), 0);
    EXPECT_NEAR(bent->ToLinear(1), 1, 1e-12);
    for (int i = 1; i < 8; ++i)
      EXPECT_NEAR(bent->ToLinear(i / 8.0), base.ToLinear(i / 8.0 + bends[static_cast<std::size_t>(i - 1)]), 1e-6);
    const auto table = bent->LinearTable();
    for (std::size_t i = 1; i < table.size(); ++i) EXPECT_GT(table[i], table[i - 1]);
    for (int i = 0; i < 256; ++i) EXPECT_NEAR(bent->FromLinear(bent->ToLinear(i / 255.0)), i / 255.0, 1e-6);
    EXPECT_EQ(bent->WithBends({}), base);
  }
}

TEST(ToneCurve, BendsThatDoNotRiseAreNone) {
  EXPECT_FALSE(ToneCurve::Srgb().WithBends({0, 0, 0.1f, -0.1f, 0, 0, 0}));
  EXPECT_FALSE(ToneCurve::Srgb().WithBends({-0.2f, 0, 0, 0, 0, 0, 0}));
  EXPECT_FALSE(ToneCurve::Srgb().WithBends({0, 0, 0, 0, 0, 0, 0.2f}));
  EXPECT_FALSE(ToneCurve::Srgb().WithBends({0, 0, std::nanf(""), 0, 0, 0, 0}));
}

TEST(ToneCurve, LightOutsideIsCutOff) {
  EXPECT_EQ(ToneCurve::Srgb().FromLinear(1.7), ToneCurve::Srgb().FromLinear(1));
  EXPECT_EQ(ToneCurve::Linear().FromLinear(-0.1), 0);
}

TEST(ToneCurve, TableHoldsEveryValue) {
  const auto table = ToneCurve::Gamma(2.2).LinearTable();
  for (int i = 0; i < 256; ++i)
    EXPECT_FLOAT_EQ(table[static_cast<std::size_t>(i)], static_cast<float>(ToneCurve::Gamma(2.2).ToLinear(i / 255.0)));
}

}  // namespace
}  // namespace chequer
