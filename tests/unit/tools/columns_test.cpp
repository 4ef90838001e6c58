#include "tools/columns.h"

#include <gtest/gtest.h>

namespace chequer {
namespace {

TEST(Columns, AreAsWideAsTheyMustBe) {
  EXPECT_EQ(Columns({{"id", "name", "note"}, {"7", "alice", ""}, {"1234", "bo", "late"}}, "><<"),
            "  id  name   note\n   7  alice\n1234  bo     late\n");
}

TEST(Columns, CountCharactersNotBytes) { EXPECT_EQ(Columns({{"ü", "1"}, {"ab", "2"}}, "<>"), "ü   1\nab  2\n"); }

TEST(CutLines, CutsEachLine) {
  EXPECT_EQ(CutLines("abcdef\nab\nüüüü\n", 3), "abc\nab\nüüü\n");
  EXPECT_EQ(CutLines("", 3), "");
}

}  // namespace
}  // namespace chequer
