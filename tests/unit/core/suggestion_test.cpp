#include "core/suggestion.h"

#include <gtest/gtest.h>

namespace chequer {
namespace {

const std::vector<std::string> kWords{"calibration", "capture", "position", "side", "world", "fps", "m"};

TEST(NearestWord, FindsWhatWasMeant) {
  EXPECT_EQ(NearestWord("calibratoin", kWords), "calibration") << "two letters changed places";
  EXPECT_EQ(NearestWord("postion", kWords), "position") << "one is missing";
  EXPECT_EQ(NearestWord("wolrd", kWords), "world");
  EXPECT_EQ(NearestWord("wrld", kWords), "world");
  EXPECT_EQ(NearestWord("size", kWords), "side");
  EXPECT_EQ(NearestWord("Side", kWords), "side") << "case";
  EXPECT_EQ(NearestWord("calib", kWords), "calibration") << "a beginning";
}

TEST(NearestWord, IsSilentWhereNoneIsNear) {
  for (const char* typed : {"", "zebra", "x", "ca", "fxy", "poisson"})
    EXPECT_EQ(NearestWord(typed, kWords), "") << typed;
  EXPECT_EQ(NearestWord("side", {}), "");
  EXPECT_EQ(NearestWord(std::string(1 << 20, 'x'), kWords), "") << "and quick";
}

TEST(NearestWord, PrefersTheNearest) {
  EXPECT_EQ(NearestWord("frames", std::vector<std::string>{"frame", "frames"}), "frames");
  EXPECT_EQ(NearestWord("pixel-format", std::vector<std::string>{"pixel_format"}), "pixel_format");
}

TEST(UnknownWord, ListsWhatIsKnown) {
  EXPECT_EQ(UnknownWord("a command", "wrld", WordsOf("lens, world")),
            "'wrld' is not a command; did you mean 'world'? Known are lens, world");
  EXPECT_EQ(UnknownWord("a command", "zebra", WordsOf("lens, world")),
            "'zebra' is not a command; known are lens, world");
}

TEST(WordsOf, TakesAListApart) {
  EXPECT_EQ(WordsOf("a, b c, d"), (std::vector<std::string>{"a", "b c", "d"}));
  EXPECT_TRUE(WordsOf("").empty());
}

}  // namespace
}  // namespace chequer
