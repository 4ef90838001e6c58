#include "core/output_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "support/error_of.h"
#include "support/file_size_limit.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

namespace fs = std::filesystem;
using test::ErrorOf;
using test::TemporaryDirectory;
using ::testing::HasSubstr;

struct stat StatusOf(const fs::path& path) {
  struct stat status {};
  EXPECT_EQ(::lstat(path.c_str(), &status), 0) << path;
  return status;
}

std::ptrdiff_t CountIn(const fs::path& folder) { return std::distance(fs::directory_iterator(folder), {}); }

TEST(OutputFile, ReplacesNothingBeforeItIsFinished) {
  const TemporaryDirectory folder;
  WriteFileAtomically(folder / "x", "before");
  {
    OutputFile file(folder / "x");
    file.Write(std::string(200'000, 'a'));
    file.Write("b");
    EXPECT_EQ(ReadFile(folder / "x", 1 << 20), "before");
  }
  EXPECT_EQ(ReadFile(folder / "x", 1 << 20), "before");
  EXPECT_EQ(CountIn(folder.path()), 1);
  OutputFile file(folder / "x");
  file.Write("a");
  file.Write(std::string(200'000, 'b'));
  file.Write("c");
  file.Finish();
  EXPECT_EQ(ReadFile(folder / "x", 1 << 20), "a" + std::string(200'000, 'b') + "c");
  EXPECT_EQ(CountIn(folder.path()), 1);
}

TEST(OutputFile, KeepsTheModeOfTheFileBefore) {
  const TemporaryDirectory folder;
  for (const mode_t mode : {0600u, 0640u, 0777u}) {
    WriteFileAtomically(folder / "x", "before");
    ASSERT_EQ(::chmod((folder / "x").c_str(), mode), 0);
    WriteFileAtomically(folder / "x", "after");
    EXPECT_EQ(StatusOf(folder / "x").st_mode & 07777, mode);
    EXPECT_EQ(ReadFile(folder / "x", 100), "after");
  }
}

TEST(OutputFile, KeepsTheOwnerWhereItMay) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root gives files away";
  const TemporaryDirectory folder;
  WriteFileAtomically(folder / "x", "before");
  if (::chown((folder / "x").c_str(), 1234, 5678) != 0) GTEST_SKIP() << "nor does root here";
  WriteFileAtomically(folder / "x", "after");
  EXPECT_EQ(StatusOf(folder / "x").st_uid, 1234u);
  EXPECT_EQ(StatusOf(folder / "x").st_gid, 5678u);
}

TEST(OutputFile, ANewFileHasTheModeOfTheMask) {
  const TemporaryDirectory folder;
  const mode_t before = ::umask(027);
  WriteFileAtomically(folder / "x", "1");
  ::umask(before);
  EXPECT_EQ(StatusOf(folder / "x").st_mode & 07777, 0640u);
}

TEST(OutputFile, LinksStayAndLeadToTheNewFile) {
  const TemporaryDirectory folder;
  fs::create_directory(folder / "disk");
  WriteFileAtomically(folder / "disk/x", "before");
  fs::create_symlink("disk/x", folder / "relative");
  fs::create_symlink(folder / "relative", folder / "absolute");
  fs::create_symlink("disk/none yet", folder / "dangling");
  WriteFileAtomically(folder / "absolute", "after");
  WriteFileAtomically(folder / "dangling", "new");
  for (const char* link : {"relative", "absolute", "dangling"}) EXPECT_TRUE(fs::is_symlink(folder / link)) << link;
  EXPECT_EQ(ReadFile(folder / "disk/x", 100), "after");
  EXPECT_EQ(ReadFile(folder / "disk/none yet", 100), "new");
  EXPECT_EQ(CountIn(folder / "disk"), 2);
  fs::create_symlink("circle", folder / "circle");
  EXPECT_THAT(ErrorOf([&] { WriteFileAtomically(folder / "circle", "1"); }), HasSubstr("circle: cannot be written"));
}

TEST(OutputFile, DevicesStayDevices) {
  const struct stat before = StatusOf("/dev/full");
  EXPECT_THAT(ErrorOf([&] { WriteFileAtomically("/dev/full", "1"); }),
              HasSubstr("/dev/full: cannot be written: No space left on device"));
  WriteFileAtomically("/dev/null", "1");
  EXPECT_TRUE(S_ISCHR(StatusOf("/dev/full").st_mode));
  EXPECT_TRUE(S_ISCHR(StatusOf("/dev/null").st_mode));
  EXPECT_EQ(StatusOf("/dev/full").st_ino, before.st_ino);
}

TEST(OutputFile, PipesAreWrittenInto) {
  const TemporaryDirectory folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  const UniqueFd reader(::open((folder / "pipe").c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  WriteFileAtomically(folder / "pipe", "hello");
  char text[16];
  EXPECT_EQ(::read(reader.get(), text, sizeof text), 5);
  EXPECT_TRUE(S_ISFIFO(StatusOf(folder / "pipe").st_mode));
}

TEST(OutputFile, APipeThatNobodyReadsIsRefusedAtOnce) {
  const TemporaryDirectory folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(ErrorOf([&] { WriteFileAtomically(folder / "pipe", "hello"); }), HasSubstr("pipe: cannot be written"));
  EXPECT_TRUE(S_ISFIFO(StatusOf(folder / "pipe").st_mode));
}

TEST(OutputFile, AReaderThatStopsIsNotWaitedForWhereNobodyMayWait) {
  const TemporaryDirectory folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  const UniqueFd reader(::open((folder / "pipe").c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  // More than any pipe holds.
  const std::string text(8'000'000, 'x');
  EXPECT_THAT(ErrorOf([&] { WriteWithoutWaiting(folder / "pipe", text, Durability::kUnsynced); }),
              HasSubstr("pipe: cannot be written: its reader has not read"));
}

/// /dev/stdout is a link to such a name.
TEST(OutputFile, AnOpenFileOfTheProcessIsContinued) {
  const TemporaryDirectory folder;
  const UniqueFd open_file(::open((folder / "x").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
  ASSERT_EQ(::write(open_file.get(), "first ", 6), 6);
  const std::string name = "/proc/self/fd/" + std::to_string(open_file.get());
  WriteFileAtomically(name, "second");
  fs::create_symlink(name, folder / "link");
  WriteFileAtomically(folder / "link", " third");
  EXPECT_EQ(ReadFile(folder / "x", 100), "first second third");
}

/// While it lives the process is nobody, if it was root, who may write everything.
class AsNobody {
 public:
  AsNobody() : before_(::geteuid()) {
    if (before_ == 0 && ::seteuid(65534) != 0) ADD_FAILURE() << "root could not become nobody";
  }
  ~AsNobody() { EXPECT_EQ(::seteuid(before_), 0); }
  AsNobody(const AsNobody&) = delete;
  AsNobody& operator=(const AsNobody&) = delete;

 private:
  uid_t before_;
};

TEST(OutputFile, WhatIsProtectedIsNotReplaced) {
  const TemporaryDirectory folder;
  WriteFileAtomically(folder / "x", "before");
  ASSERT_EQ(::chmod((folder / "x").c_str(), 0444), 0);
  ASSERT_EQ(::chmod(folder.path().c_str(), 0777), 0);
  {
    const AsNobody nobody;
    EXPECT_THAT(ErrorOf([&] { WriteFileAtomically(folder / "x", "after"); }), HasSubstr("Permission denied"));
    EXPECT_THAT(WhyNotWritable(folder / "x"), HasSubstr("Permission denied"));
    WriteFileAtomically(folder / "y", "new");
  }
  EXPECT_EQ(ReadFile(folder / "x", 100), "before");
}

TEST(OutputFile, AFullDiskLeavesTheFileBefore) {
  const TemporaryDirectory folder;
  WriteFileAtomically(folder / "x", "before");
  {
    const test::FileSizeLimit limit(1000);
    EXPECT_THAT(ErrorOf([&] { WriteFileAtomically(folder / "x", std::string(2000, 'a')); }),
                HasSubstr("x: cannot be written: File too large"));
  }
  EXPECT_EQ(ReadFile(folder / "x", 100), "before");
  EXPECT_EQ(CountIn(folder.path()), 1);
}

/// Somebody else may write into the folder, such as /tmp: no name there can be guessed and led elsewhere.
TEST(OutputFile, DoesNotFollowALinkThatLiesInWait) {
  const TemporaryDirectory folder;
  WriteFileAtomically(folder / "precious", "kept");
  fs::create_symlink("precious", folder / "x.partial");
  WriteFileAtomically(folder / "x", "1");
  EXPECT_EQ(ReadFile(folder / "precious", 100), "kept");
}

TEST(OutputFile, SaysBeforehandWhyNot) {
  const TemporaryDirectory folder;
  EXPECT_EQ(WhyNotWritable(folder / "x"), "");
  EXPECT_EQ(WhyNotWritable("/dev/full"), "");
  EXPECT_EQ(WhyNotWritable("/dev/stdout"), "");
  EXPECT_THAT(WhyNotWritable(folder.path()), HasSubstr("directory"));
  EXPECT_THAT(WhyNotWritable(folder / "none/x"), HasSubstr("there is no folder " + (folder / "none").string()));
}

}  // namespace
}  // namespace chequer
