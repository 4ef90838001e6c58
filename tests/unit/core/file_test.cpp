#include "core/file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "core/unique_fd.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

using test::ErrorOf;
using ::testing::HasSubstr;

TEST(File, WhatIsWrittenIsRead) {
  const test::TemporaryDirectory folder;
  const std::string bytes("a\0b\xff\n", 5);
  WriteFileAtomically(folder / "x", "first, and longer");
  WriteFileAtomically(folder / "x", bytes);
  EXPECT_EQ(ReadFile(folder / "x", 5), bytes);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(File, ReadsWhatTellsNoSize) { EXPECT_THAT(ReadFile("/proc/self/status", 1 << 20), HasSubstr("Name:")); }

TEST(File, NamesFileAndCause) {
  const test::TemporaryDirectory folder;
  WriteFileAtomically(folder / "x", "123456");
  const std::string name = (folder / "x").string();
  EXPECT_EQ(ErrorOf([&] { ReadFile(folder / "x", 5); }), name + ": longer than the 5 bytes allowed here");
  EXPECT_EQ(ErrorOf([&] { ReadFile(folder.path(), 5); }), folder.path().string() + ": is a folder, not a file");
  EXPECT_EQ(ErrorOf([&] { ReadFile(folder / "y", 5); }),
            (folder / "y").string() + ": cannot be opened: No such file or directory");
  EXPECT_EQ(ErrorOf([&] { WriteFileAtomically(folder / "no/x", "1"); }),
            (folder / "no/x").string() + ": cannot be written: No such file or directory");
}

/// Bytes that this process has read so far; none where the system does not count them.
std::optional<std::uint64_t> BytesRead() {
  std::ifstream counts("/proc/self/io");
  std::string name;
  std::uint64_t bytes = 0;
  if (!(counts >> name >> bytes) || name != "rchar:") return std::nullopt;
  return bytes;
}

TEST(File, ReadsNothingOfAFileThatIsTooLong) {
  const std::optional<std::uint64_t> before = BytesRead();
  if (!before) GTEST_SKIP() << "this system counts no bytes";
  const test::TemporaryDirectory folder;
  WriteFileAtomically(folder / "x", "1");
  std::filesystem::resize_file(folder / "x", 8'000'000);
  EXPECT_THAT(ErrorOf([&] { ReadFile(folder / "x", 4'000'000); }), HasSubstr("longer than the 4000000 bytes"));
  EXPECT_LT(*BytesRead() - *before, 1'000'000u);
}

// With nobody at its other end, opening a pipe waits for ever; so may reading a terminal.
TEST(File, DoesNotWaitForWhatIsNoFile) {
  const test::TemporaryDirectory folder;
  const std::string pipe = (folder / "pipe").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(ErrorOf([&] { ReadFile(pipe, 5); }), pipe + ": is a pipe, not a file");
  // Nor with somebody there who says nothing.
  const UniqueFd silent(::open(pipe.c_str(), O_RDWR | O_CLOEXEC));
  EXPECT_EQ(ErrorOf([&] { ReadFile(pipe, 5); }), pipe + ": is a pipe, not a file");
  std::filesystem::create_symlink(pipe, folder / "link");
  EXPECT_THAT(ErrorOf([&] { ReadFile(folder / "link", 5); }), HasSubstr("is a pipe"));
  EXPECT_EQ(ErrorOf([&] { ReadFile("/dev/zero", 5); }), "/dev/zero: is a device, not a file");
  EXPECT_EQ(ErrorOf([&] { ReadFile("/dev/tty", 5); }), "/dev/tty: is a device, not a file");
  const UniqueFd listening(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const std::string name = (folder / "socket").string();
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  name.copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(listening.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  EXPECT_EQ(ErrorOf([&] { ReadFile(name, 5); }), name + ": is a socket, not a file");
}

TEST(File, ANameThatCannotBeReplacedLeavesNothingBehind) {
  const test::TemporaryDirectory folder;
  std::filesystem::create_directory(folder / "x");
  WriteFileAtomically(folder / "x/inside", "1");
  EXPECT_THAT(ErrorOf([&] { WriteFileAtomically(folder / "x", "1"); }), HasSubstr("x: cannot be written: "));
  EXPECT_FALSE(std::filesystem::exists(folder / "x.partial"));
}

TEST(UniqueFd, ClosesOnceAndMoves) {
  UniqueFd fd(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  const int number = fd.get();
  UniqueFd other = std::move(fd);
  EXPECT_FALSE(fd.valid());
  EXPECT_EQ(other.get(), number);
  EXPECT_EQ(other.Close(), 0);
  EXPECT_FALSE(other.valid());
  EXPECT_EQ(::fcntl(number, F_GETFD), -1);
}

}  // namespace
}  // namespace chequer
