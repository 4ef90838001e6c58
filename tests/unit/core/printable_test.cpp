#include "core/printable.h"

#include <gtest/gtest.h>

namespace chequer {
namespace {

TEST(Printable, LeavesTextsOfAnyLanguageAlone) {
  for (const char* text : {"", "north", "Küche 1", "カメラ", "🤖 x²", "a ~ b"}) {
    EXPECT_EQ(Printable(text), text);
    EXPECT_EQ(PrintableJson(text), text);
  }
}

TEST(Printable, TakesAwayWhatATerminalObeys) {
  EXPECT_EQ(Printable("\x1b[2Jx\a\x7f"), "?[2Jx??");
  EXPECT_EQ(Printable("a\nb\rc\td"), "a?b?c?d");
  EXPECT_EQ(Printable("\u009b2J\u0085\u0080"), "?2J??") << "C1, as UTF-8";
  EXPECT_EQ(Printable("\x9b"
                      "2J"),
            "?2J")
      << "C1, as a byte of its own";
  EXPECT_EQ(Printable("\u202Etxt\u2066\u2028\u200f"), "?txt???");
  EXPECT_EQ(Printable(std::string_view("a\0b", 3)), "a?b");
}

TEST(Printable, GivesValidUtf8) {
  EXPECT_EQ(Printable("\xff\xfe"), "??");
  EXPECT_EQ(Printable("\xc0\x9b"), "??") << "longer than needed";
  EXPECT_EQ(Printable("\xe0\x82\x9b"), "???");
  EXPECT_EQ(Printable("\xed\xa0\x80"), "???") << "half of a pair";
  EXPECT_EQ(Printable("\xf4\x90\x80\x80"), "????");
  EXPECT_EQ(Printable("\xe2\x82"), "??") << "cut off";
  EXPECT_EQ(Printable("\xe2\x82x"), "??x");
}

TEST(Printable, IsBounded) {
  EXPECT_EQ(Printable(std::string(1000, 'x')), std::string(1000, 'x'));
  EXPECT_EQ(Printable(std::string(1'000'000, 'x')), std::string(1000, 'x') + "…");
}

TEST(PrintableLines, KeepsLines) { EXPECT_EQ(PrintableLines("a\n\tb\x1b\u009b"), "a\n\tb??"); }

TEST(PrintableJson, SaysTheSameInEscapes) {
  EXPECT_EQ(PrintableJson("{\"a\":\"\u009b\x7f\u202e\"}"), R"({"a":"\u009b\u007f\u202e"})");
}

}  // namespace
}  // namespace chequer
