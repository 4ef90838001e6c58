#include "detect/fit/fit_choice.h"

#include <gtest/gtest.h>

#include <cmath>

namespace chequer {
namespace {

constexpr Explained kPlain{.pixels = 1000, .fits = 1000, .deviation = 0.01, .unknowns = 100, .contrast = 0.5};

TEST(FitChoice, UnknownsThatExplainNothingAreNotBetter) {
  // Of noise that k of n unknowns explain, a share of 1 − k / n is left.
  for (const double more : {1, 30, 200}) {
    Explained richer = kPlain;
    richer.unknowns += more;
    richer.deviation *= std::sqrt((richer.fits - richer.unknowns) / (kPlain.fits - kPlain.unknowns));
    EXPECT_FALSE(Better(richer, kPlain, 0)) << more;
    EXPECT_TRUE(Better(kPlain, richer, 0)) << more;
  }
}

TEST(FitChoice, GivingUpCornersCostsWhatTheirPixelsTell) {
  Explained fewer = kPlain;
  fewer.fits = 800;
  fewer.deviation = 0.008;
  EXPECT_FALSE(Better(fewer, kPlain, 0));
  // A contrast of 50 : 1 on all pixels is worth one of 50^(10/8) : 1 on eight of ten, and more for the unknowns.
  fewer.deviation = 0.5 / 150;
  EXPECT_TRUE(Better(fewer, kPlain, 0));
}

TEST(FitChoice, UnusedCornersTellWhatTheyShowAllTheSame) {
  Explained given_up = kPlain, seen = kPlain;
  given_up.fits = seen.fits = 800;
  seen.unused = 200;
  seen.unused_logs = 200 * std::log(0.1);
  EXPECT_TRUE(Better(seen, given_up, 0));
  EXPECT_FALSE(Better(seen, kPlain, 0));
}

TEST(FitChoice, FitsToSomeOfThePixelsCompare) {
  Explained by_some = kPlain, better = kPlain;
  better.deviation *= 0.9;
  by_some.pixels = by_some.fits = 700;
  by_some.unknowns = 70;
  EXPECT_FALSE(Better(by_some, better, 0));
  EXPECT_TRUE(Better(better, by_some, 0));
  EXPECT_TRUE(MayBeBetter(by_some, better, 0));
}

}  // namespace
}  // namespace chequer
