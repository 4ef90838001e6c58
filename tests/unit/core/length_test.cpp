#include "core/length.h"

#include <gtest/gtest.h>

namespace chequer {
namespace {

TEST(ParseLength, KnowsUnits) {
  EXPECT_EQ(ParseLength("60mm"), 0.06);
  EXPECT_EQ(ParseLength("6cm"), 0.06);
  EXPECT_EQ(ParseLength("6 cm"), 0.06);
  EXPECT_EQ(ParseLength("0.06m"), 0.06);
  EXPECT_EQ(ParseLength("3.45um"), 3.45e-6);
  EXPECT_EQ(ParseLength("-20cm"), -0.2);
}

TEST(ParseLength, TakesABareNumberAsMetresUnlessSaidOtherwise) {
  EXPECT_EQ(ParseLength("0.06"), 0.06);
  EXPECT_EQ(ParseLength("60"), 60);
  EXPECT_EQ(ParseLength("12", 1e-3), 0.012);
  EXPECT_EQ(ParseLength("12cm", 1e-3), 0.12);
}

TEST(ParseLength, RefusesWhatIsNoLength) {
  for (const char* text : {"", "mm", "m", "60 miles", "60mmm", "6x", "nan", "inf", "nanmm", "1e999", "60  mm", "+ 3"})
    EXPECT_FALSE(ParseLength(text)) << text;
}

TEST(DidYouMeanMillimetres, SpeaksOfLargeBareNumbersAlone) {
  EXPECT_EQ(DidYouMeanMillimetres("60"), "; a bare number is in metres: did you mean \"60mm\"?");
  for (const char* text : {"0.06", "1.5", "60mm", "6m", "x"}) EXPECT_EQ(DidYouMeanMillimetres(text), "") << text;
}

TEST(LengthText, ReadsAsPeopleSayIt) {
  EXPECT_EQ(LengthText(0.12), "120 mm");
  EXPECT_EQ(LengthText(1.25), "1.25 m");
}

}  // namespace
}  // namespace chequer
