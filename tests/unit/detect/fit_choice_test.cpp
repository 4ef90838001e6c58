#include "detect/fit/fit_choice.h"

#include <gtest/gtest.h>

#include <cmath>

namespace chequer {
namespace {

constexpr int kCorners = 10;

/// A fit that uses all of some corners with 100 pixels each.
Explained Plain(float pixels = 100) {
  Explained plain{.corners = {}, .deviation = 0.01, .unknowns = 100, .contrast = 0.5};
  for (std::size_t i = 0; i < kCorners; ++i) plain.corners[i] = {pixels, pixels, 0};
  return plain;
}

void GiveUp(Explained& fit, std::size_t count, float own_deviation) {
  for (std::size_t i = 0; i < count; ++i) fit.corners[i].own_deviation = own_deviation;
}

TEST(FitChoice, UnknownsThatExplainNothingAreNotBetter) {
  // Of noise that k of n unknowns explain, a share of 1 − k / n is left.
  const Explained plain = Plain();
  for (const double more : {1, 30, 200}) {
    Explained richer = plain;
    richer.unknowns += more;
    richer.deviation *= std::sqrt((1000 - richer.unknowns) / (1000 - plain.unknowns));
    EXPECT_FALSE(Better(richer, plain, 0)) << more;
    EXPECT_TRUE(Better(plain, richer, 0)) << more;
  }
}

TEST(FitChoice, FewerPixelsSayNothingAgainstAModel) {
  // The same noise, of which unknowns explain their share: a third of 300 pixels, a hundredth of 10,000.
  Explained all = Plain(1000), some = Plain(30);
  some.unknowns = all.unknowns = 100;
  const double noise = 0.01;
  all.deviation = noise * std::sqrt(0.99), some.deviation = noise * std::sqrt(2.0 / 3);
  EXPECT_FALSE(Better(some, all, 1e-6));
  EXPECT_FALSE(Better(all, some, 1e-6));
  some.deviation *= 0.99;
  EXPECT_TRUE(Better(some, all, 1e-6));
}

TEST(FitChoice, GivingUpCornersCostsWhatTheirPixelsTell) {
  Explained fewer = Plain();
  GiveUp(fewer, 2, 1e3f);
  fewer.deviation = 0.008;
  EXPECT_FALSE(Better(fewer, Plain(), 0));
  // A contrast of 50 : 1 on all pixels is worth one of 50^(10/8) : 1 on eight of ten, and more for the unknowns.
  fewer.deviation = 0.5 / 150;
  EXPECT_TRUE(Better(fewer, Plain(), 0));
}

TEST(FitChoice, UnusedCornersTellWhatTheyShowAllTheSame) {
  Explained given_up = Plain(), seen = Plain();
  GiveUp(given_up, 2, 1e3f);
  GiveUp(seen, 2, 10);
  EXPECT_FALSE(Better(seen, Plain(), 0));
  given_up.deviation = seen.deviation = 0.005;
  EXPECT_FALSE(Better(given_up, Plain(), 0));
  EXPECT_TRUE(Better(seen, Plain(), 0));
}

TEST(FitChoice, CornersThatBothGiveUpTellNothing) {
  Explained fit = Plain(), other = Plain();
  GiveUp(fit, 2, 1e3f);
  GiveUp(other, 2, 10);
  EXPECT_FALSE(Better(other, fit, 0));
  fit.deviation *= 0.99;
  EXPECT_TRUE(Better(fit, other, 0));
}

TEST(FitChoice, FitsToSomeOfThePixelsCompare) {
  Explained by_some = Plain(70), better = Plain();
  better.deviation *= 0.9;
  by_some.unknowns = 70;
  EXPECT_FALSE(Better(by_some, better, 0));
  EXPECT_TRUE(Better(better, by_some, 0));
  EXPECT_TRUE(MayBeBetter(by_some, better, 0));
}

}  // namespace
}  // namespace chequer
