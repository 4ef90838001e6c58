#include "core/set_aside.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <stdexcept>
#include <string>
#include <system_error>

namespace chequer {
namespace {

/// More logs of one second than that are not written.
constexpr int kMostNames = 10'000;

[[noreturn]] void Fail(const std::filesystem::path& path, int error) {
  throw std::runtime_error(path.string() + ": cannot be renamed to make room: " + std::strerror(error));
}

std::string TimeText(std::time_t time) {
  std::tm utc{};
  gmtime_r(&time, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y%m%dT%H%M%SZ", &utc);
  return text.data();
}

/// Renames where nothing has that name yet; 0 or an errno.
int RenameToNew(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return errno;
  // A file system without it: a second name is never given to two files either.
  if (::link(from.c_str(), to.c_str()) != 0) return errno;
  return ::unlink(from.c_str()) == 0 ? 0 : errno;
}

/// Copies where there are no second names (FAT); 0 or an errno.
int LinkOrCopy(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::link(from.c_str(), to.c_str()) == 0) return 0;
  if (errno != EPERM && errno != EOPNOTSUPP && errno != EMLINK) return errno;
  std::error_code error;
  std::filesystem::copy_file(from, to, error);
  return error.value();
}

/// @param give a name to a file: 0 or an errno.
template <typename Give>
std::filesystem::path GiveName(const std::filesystem::path& path, const Give& give) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) Fail(path, errno);
  const std::string begin = path.stem().string() + "-" + TimeText(status.st_mtim.tv_sec);
  for (int i = 1; i < kMostNames; ++i) {
    std::string name = begin;
    if (i > 1) name.append("-").append(std::to_string(i));
    const std::filesystem::path aside = path.parent_path() / name.append(path.extension().string());
    const int error = give(path, aside);
    if (error == 0) return aside;
    if (error != EEXIST) Fail(path, error);
  }
  Fail(path, EEXIST);
}

}  // namespace

std::filesystem::path SetAside(const std::filesystem::path& path) { return GiveName(path, RenameToNew); }

std::filesystem::path KeepAside(const std::filesystem::path& path) { return GiveName(path, LinkOrCopy); }

}  // namespace chequer
