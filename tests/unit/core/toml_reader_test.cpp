#include "core/toml_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>

#include "core/toml_text.h"
#include "support/error_of.h"

namespace chequer {
namespace {

using ::testing::ElementsAre;
using ::testing::Eq;
using ::testing::HasSubstr;

/// What reading a text throws.
std::string ErrorOfText(
    const std::string& text, const std::function<void(TomlTable)>& read = [](TomlTable) {}) {
  return test::ErrorOf([&] {
    TomlFile file = TomlFile::Parse(text, "swarm.toml");
    read(file.root());
    file.CheckAllKeysRead();
  });
}

TEST(TomlReader, ReadsEveryType) {
  TomlFile file = TomlFile::Parse(R"(
    flag = true
    rate = 60
    gain = 0.5
    count = 7
    big = 9223372036854775807
    name = "Größe"
    list = [1, 2.5]
    ids = [3, 4]
    words = ["a", "b"]
    mode = "fast"
    [inner]
    x = 1
    [[out]]
    n = 1
    [[out]]
    n = 2)",
                                  "swarm.toml");
  TomlTable root = file.root();
  bool flag = false;
  double rate = 0, gain = 0;
  int count = 0, x = 0;
  std::uint64_t big = 0;
  std::string name;
  std::vector<double> list;
  std::vector<std::int64_t> ids;
  std::vector<std::string> words;
  int mode = 0;
  constexpr std::array<std::pair<std::string_view, int>, 2> kModes{{{"slow", 1}, {"fast", 2}}};
  EXPECT_TRUE(root.Read("flag", flag));
  EXPECT_TRUE(root.Read("rate", rate, NumberRange{0, 100}));
  EXPECT_TRUE(root.Read("gain", gain, NumberRange{0, 1}));
  EXPECT_TRUE(root.Read("count", count, IntegerRange{7, 7}));
  EXPECT_TRUE(root.Read("big", big, IntegerRange{0, INT64_MAX}));
  EXPECT_TRUE(root.Read("name", name));
  EXPECT_TRUE(root.Read("list", list, LengthRange{2, 2}, NumberRange{0, 10}));
  EXPECT_TRUE(root.Read("ids", ids, LengthRange{0, 10}, IntegerRange{0, 10}));
  EXPECT_TRUE(root.Read("words", words, LengthRange{0, 10}));
  EXPECT_TRUE(root.Read("mode", mode, kModes));
  EXPECT_TRUE(root.Table("inner").Read("x", x, IntegerRange{0, 10}));
  std::vector<int> outs;
  for (TomlTable out : root.Tables("out", 2)) out.Read("n", outs.emplace_back(), IntegerRange{0, 10});
  file.CheckAllKeysRead();

  EXPECT_TRUE(flag);
  EXPECT_EQ(rate, 60);
  EXPECT_EQ(gain, 0.5);
  EXPECT_EQ(count, 7);
  EXPECT_EQ(big, 9223372036854775807u);
  EXPECT_EQ(name, "Größe");
  EXPECT_THAT(list, ElementsAre(1, 2.5));
  EXPECT_THAT(ids, ElementsAre(3, 4));
  EXPECT_THAT(words, ElementsAre("a", "b"));
  EXPECT_EQ(mode, 2);
  EXPECT_EQ(x, 1);
  EXPECT_THAT(outs, ElementsAre(1, 2));
}

TEST(TomlReader, AMissingKeyLeavesTheDefault) {
  TomlFile file = TomlFile::Parse("", "swarm.toml");
  double rate = 25;
  EXPECT_FALSE(file.root().Table("capture").Read("rate", rate, NumberRange{0, 100}));
  EXPECT_EQ(rate, 25);
  EXPECT_TRUE(file.root().Tables("out", 1).empty());
}

TEST(TomlReader, NamesFileLineKeyValueAndRange) {
  EXPECT_EQ(ErrorOfText("\n[capture]\nfps = -3",
                        [](TomlTable root) {
                          double fps = 0;
                          root.Table("capture").Read("fps", fps, NumberRange{0.1, 1000});
                        }),
            "swarm.toml:3: capture.fps = -3: must be from 0.1 to 1000");
}

struct BadValue {
  const char* value;
  std::function<void(TomlTable)> read;
  const char* expected;
};

class TomlReaderRefuses : public ::testing::TestWithParam<BadValue> {};

TEST_P(TomlReaderRefuses, WhatDoesNotFit) {
  EXPECT_THAT(ErrorOfText(std::string("k = ") + GetParam().value, GetParam().read), HasSubstr(GetParam().expected));
}

void ReadBool(TomlTable t) {
  bool v = false;
  t.Read("k", v);
}
void ReadNumber(TomlTable t) {
  double v = 0;
  t.Read("k", v, NumberRange{0, 1});
}
void ReadInt(TomlTable t) {
  int v = 0;
  t.Read("k", v, IntegerRange{INT64_MIN, INT64_MAX});
}
void ReadUnsigned(TomlTable t) {
  std::uint64_t v = 0;
  t.Read("k", v, IntegerRange{INT64_MIN, INT64_MAX});
}
void ReadText(TomlTable t) {
  std::string v;
  t.Read("k", v, LengthRange{1, 3});
}
void ReadNumbers(TomlTable t) {
  std::vector<double> v;
  t.Read("k", v, LengthRange{2, 2}, NumberRange{0, 1});
}
void ReadTable(TomlTable t) { t.Table("k"); }
void ReadTables(TomlTable t) { t.Tables("k", 1); }

INSTANTIATE_TEST_SUITE_P(All, TomlReaderRefuses,
                         ::testing::Values(BadValue{"1", ReadBool, "k = 1: must be true or false"},
                                           BadValue{"\"1\"", ReadNumber, "k = '1': must be a number from 0 to 1"},
                                           BadValue{"nan", ReadNumber, "k = nan: must be from 0 to 1"},
                                           BadValue{"-inf", ReadNumber, "k = -inf: must be from 0 to 1"},
                                           BadValue{"-0.1", ReadNumber, "k = -0.1: must be from 0 to 1"},
                                           BadValue{"1.0001", ReadNumber, "k = 1.0001: must be from 0 to 1"},
                                           BadValue{"1.0", ReadInt, "k = 1.0: must be a whole number"},
                                           BadValue{"2147483648", ReadInt, "must be from -2147483648 to 2147483647"},
                                           BadValue{"-1", ReadUnsigned, "k = -1: must be at least 0"},
                                           BadValue{"\"\"", ReadText, "must have 1 to 3 characters"},
                                           BadValue{"\"abcd\"", ReadText, "must have 1 to 3 characters"},
                                           BadValue{"\"a\\u0000\"", ReadText, "must not contain the character 0"},
                                           BadValue{"7", ReadText, "k = 7: must be a text in quotes"},
                                           BadValue{"[1]", ReadNumbers, "must have 2 values"},
                                           BadValue{"1", ReadNumbers, "must be a list of 2 values"},
                                           BadValue{"[1, 2]", ReadNumbers, "value 2 (2) must be from 0 to 1"},
                                           BadValue{"[1, true]", ReadNumbers,
                                                    "value 2 (true) must be a number from 0 to 1"},
                                           BadValue{"1", ReadTable, "must be a table, written [k]"},
                                           BadValue{"{}", ReadTables, "must be tables, each written [[k]]"},
                                           BadValue{"[{}, {}]", ReadTables, "must be at most 1 tables"}));

TEST(TomlReader, RefusesTheFirstKeyNobodyAskedFor) {
  const auto read = [](TomlTable root) {
    double fps = 0;
    int threads = 0;
    TomlTable capture = root.Table("capture");
    capture.Read("fps", fps, NumberRange{0, 100});
    capture.Read("threads", threads, IntegerRange{0, 100});
  };
  EXPECT_EQ(ErrorOfText("[capture]\nfps = 1\nfsp = 2\n[other]\n", read),
            "swarm.toml:3: capture.fsp: unknown key (did you mean 'fps'?); known here: fps, threads");
  EXPECT_EQ(ErrorOfText("[capture]\nfps = 1\n[other]\nx = 1\n", read),
            "swarm.toml:3: other: unknown key; known here: capture");
}

TEST(TomlReader, RefusesUnknownKeysInEachTableOfAList) {
  const auto read = [](TomlTable root) {
    for (TomlTable out : root.Tables("out", 9)) ReadNumber(out);
  };
  EXPECT_EQ(ErrorOfText("[[out]]\nk = 1\n[[out]]\nq = 1", read), "swarm.toml:4: out[1].q: unknown key; known here: k");
}

TEST(TomlReader, RequiredKeysMustBeThere) {
  EXPECT_EQ(ErrorOfText("\n[a]\n",
                        [](TomlTable root) {
                          int x = 0;
                          root.Table("a").Require("x", x, IntegerRange{0, 1});
                        }),
            "swarm.toml:2: a.x: is missing and has no default");
}

TEST(TomlReader, NamesTheLineOfASyntaxError) {
  EXPECT_THAT(ErrorOfText("a = 1\nb = = 2"), HasSubstr("swarm.toml:2: not valid TOML: "));
  EXPECT_THAT(ErrorOfText("a = 1\na = 2"), HasSubstr("swarm.toml:2: not valid TOML: "));
  EXPECT_THAT(ErrorOfText("a = \"\xff\""), Eq("swarm.toml:1: the text is not UTF-8"));
}

TEST(TomlReader, SurvivesHostileText) {
  EXPECT_THAT(ErrorOfText(std::string(kMaxTomlBytes + 1, ' ')), HasSubstr("swarm.toml: longer than the 1048576 bytes"));
  EXPECT_THAT(ErrorOfText("a = " + std::string(100000, '[')), HasSubstr("swarm.toml:1: not valid TOML: "));
  std::string deep = "\na";
  for (int i = 0; i < 300000; ++i) deep += ".a";
  EXPECT_EQ(ErrorOfText(deep + " = 1"), "swarm.toml:2: a key must have at most 8 parts");
  deep.front() = '[';
  EXPECT_EQ(ErrorOfText(deep + "]"), "swarm.toml:1: a key must have at most 8 parts");
  const std::string long_text = ErrorOfText("k = '" + std::string(5000, 'x') + "'", ReadText);
  EXPECT_LT(long_text.size(), 200u);
}

/// Where something is wrong; 0 where nothing is.
int WrongLine(std::string_view text) { return PrepareToml(text, 2).line; }

TEST(PrepareToml, CountsPartsOfKeysOnly) {
  EXPECT_EQ(WrongLine("a.b = 1\nc.d.e = 1"), 2);
  EXPECT_EQ(WrongLine("a = [0.1, 0.2, 0.3]\n"), 0);
  EXPECT_EQ(WrongLine("a = 'x.y.z' # a.b.c.d\n"), 0);
  EXPECT_EQ(WrongLine("a = ''\nb.c.d = ''"), 2);
  EXPECT_EQ(WrongLine("\"a,b\".\",\".\"]\" = 1"), 1);
  EXPECT_EQ(WrongLine("a = \"\\\"\"\nb.c.d = 1"), 2);
  EXPECT_EQ(WrongLine("a = '\\'\nb.c.d = 1"), 2);
  EXPECT_EQ(WrongLine("a = \"open.x.y.z\nb.c.d = 1"), 2);
  EXPECT_EQ(WrongLine("a = \"open\\"), 0);
  EXPECT_EQ(WrongLine("a = \""), 0);
}

TEST(PrepareToml, LeavesAsciiAlone) {
  const char* text = "a = 'x' # y\n[b]\nc = \"\\\"\\\\\" \t\r\n";
  EXPECT_EQ(PrepareToml(text, 2).text, text);
}

TEST(PrepareToml, EscapesOtherScriptsInDoubleQuotes) {
  EXPECT_EQ(PrepareToml("a = \"ö€😀\"", 2).text, "a = \"\\U000000f6\\U000020ac\\U0001f600\"");
  EXPECT_EQ(PrepareToml("\xef\xbb\xbf# with a byte order mark: ö", 2).text, "# with a byte order mark: ??");
  EXPECT_EQ(WrongLine("a = 'ö'"), 1);
  EXPECT_EQ(WrongLine("a = 1\nGröße = 2"), 2);
  EXPECT_EQ(WrongLine("a = 1 \xef\xbb\xbd"), 1);
  EXPECT_EQ(ErrorOfText("Größe = 2"), "swarm.toml:1: characters beyond ASCII must stand in double quotes or comments");
}

TEST(PrepareToml, RefusesWhatIsNotUtf8) {
  for (const char* bytes : {"\xff", "\x80", "\xc3", "\xc0\x80", "\xe0\x80\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80",
                            "\xf5\x80\x80\x80", "\xc3("})
    EXPECT_EQ(PrepareToml("a = \"" + std::string(bytes) + "\"", 2).wrong, "the text is not UTF-8");
}

TEST(PrepareToml, RefusesThreeQuotes) {
  EXPECT_EQ(WrongLine("a = ''\nb = \"\"\"x\"\"\""), 2);
  EXPECT_EQ(WrongLine("b = '''x'''"), 1);
  EXPECT_EQ(WrongLine("b = ['', \"\"] # '''"), 0);
  EXPECT_EQ(ErrorOfText("b = '''x'''"), "swarm.toml:1: texts in three quotes are not read here: use one");
}

TEST(TomlReader, ReadsLengthsWithAndWithoutUnits) {
  TomlFile file = TomlFile::Parse("a = \"60mm\"\nb = 0.06\nc = \"6 cm\"\nd = [\"1.2m\", -0.3, \"45mm\"]", "");
  TomlTable root = file.root();
  double metres = 0;
  for (const char* key : {"a", "b", "c"}) {
    ASSERT_TRUE(root.ReadLength(key, metres, {0.001, 99}));
    EXPECT_EQ(metres, 0.06) << key;
  }
  EXPECT_FALSE(root.ReadLength("none", metres, {0, 1}));
  std::vector<double> list;
  ASSERT_TRUE(root.ReadLengths("d", list, {1, 3}, {-10, 10}));
  EXPECT_EQ(list, (std::vector{1.2, -0.3, 0.045}));
}

TEST(TomlReader, RefusesLengthsWithAHint) {
  const auto wrong = [](const std::string& value) {
    return ErrorOfText("side = " + value, [](TomlTable root) {
      double metres = 0;
      root.ReadLength("side", metres, {0.001, 99});
    });
  };
  EXPECT_EQ(
      wrong("120"),
      "swarm.toml:1: side = 120: must be from 0.001 to 99 m; a bare number is in metres: did you mean \"120mm\"?");
  EXPECT_EQ(wrong("0.0001"), "swarm.toml:1: side = 0.0001: must be from 0.001 to 99 m");
  EXPECT_THAT(wrong("\"60 miles\""), ::testing::HasSubstr("must be a length from 0.001 to 99 m, written \"60mm\""));
  EXPECT_THAT(wrong("nan"), ::testing::HasSubstr("must be"));
  EXPECT_THAT(wrong("true"), ::testing::HasSubstr("must be a length"));
}

TEST(TomlReader, SuggestsTheWordThatWasMeant) {
  const auto read = [](TomlTable root) {
    int value = 0;
    constexpr std::array<std::pair<std::string_view, int>, 2> kWords{{{"newest", 1}, {"wait", 2}}};
    root.Read("when", value, kWords);
  };
  EXPECT_EQ(ErrorOfText("when = 'newset'", read),
            "swarm.toml:1: when = 'newset': must be \"newest\" or \"wait\"; did you mean 'newest'?");
}

TEST(TomlReader, NamesTheKeyThatLooksLikeAMissingOne) {
  const auto read = [](TomlTable root) {
    std::string value;
    root.Table("a").Require("position", value);
  };
  EXPECT_EQ(ErrorOfText("[a]\nx = 1\npostion = 2", read),
            "swarm.toml:1: a.position: is missing and has no default (line 3 has 'postion'; did you mean that?)");
}

}  // namespace
}  // namespace chequer
