#include "core/set_aside.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "core/file.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

using ::testing::HasSubstr;

std::filesystem::path SetAsideAt(const std::filesystem::path& path, std::time_t time) {
  const timespec times[2]{{time, 0}, {time, 0}};
  EXPECT_EQ(utimensat(AT_FDCWD, path.c_str(), times, 0), 0);
  return SetAside(path);
}

TEST(SetAside, PutsTheTimeOfTheFileIntoItsName) {
  const test::TemporaryDirectory folder;
  for (const char* text : {"first", "second", "third"}) {
    WriteFileAtomically(folder / "a.b.lcm", text);
    SetAsideAt(folder / "a.b.lcm", 1'700'000'000);
  }
  EXPECT_EQ(ReadFile(folder / "a.b-20231114T221320Z.lcm", 100), "first");
  EXPECT_EQ(ReadFile(folder / "a.b-20231114T221320Z-2.lcm", 100), "second");
  EXPECT_EQ(ReadFile(folder / "a.b-20231114T221320Z-3.lcm", 100), "third");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.b.lcm"));
}

TEST(KeepAside, LeavesTheFileWhereItIs) {
  const test::TemporaryDirectory folder;
  WriteFileAtomically(folder / "a.toml", "before");
  const std::filesystem::path kept = KeepAside(folder / "a.toml");
  EXPECT_EQ(ReadFile(folder / "a.toml", 100), "before");
  WriteFileAtomically(folder / "a.toml", "after");
  EXPECT_EQ(ReadFile(kept, 100), "before");
}

TEST(SetAside, NamesWhatCannotBeRenamed) {
  const test::TemporaryDirectory folder;
  EXPECT_THAT(test::ErrorOf([&] { SetAside(folder / "missing"); }), HasSubstr("missing: cannot be renamed"));
}

}  // namespace
}  // namespace chequer
