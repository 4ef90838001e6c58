#include "chequer/tone_curve.h"

#include <gtest/gtest.h>

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
