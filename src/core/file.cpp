#include "core/file.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "core/unique_fd.h"

namespace chequer {
namespace {

[[noreturn]] void Fail(const std::filesystem::path& path, const std::string& what, int error) {
  throw std::runtime_error(path.string() + ": " + what + ": " + std::strerror(error));
}

[[noreturn]] void FailAsTooLong(const std::filesystem::path& path, std::size_t max_bytes) {
  throw std::runtime_error(path.string() + ": longer than the " + std::to_string(max_bytes) + " bytes allowed here");
}

/// Throws where it is no regular file.
void CheckIsRegular(const struct stat& status, const std::filesystem::path& path) {
  const char* kind = nullptr;
  switch (status.st_mode & S_IFMT) {
    case S_IFREG: return;
    case S_IFDIR: kind = "a folder"; break;
    case S_IFIFO: kind = "a pipe"; break;
    case S_IFSOCK: kind = "a socket"; break;
    default: kind = "a device"; break;
  }
  throw std::runtime_error(path.string() + ": is " + kind + ", not a file");
}

std::string ReadAll(const UniqueFd& fd, const std::filesystem::path& path, std::size_t size_hint,
                    std::size_t max_bytes) {
  std::string bytes;
  std::size_t used = 0;
  // One byte more than the size, so that the end of an ordinary file is seen without growing.
  bytes.resize(std::min(size_hint, max_bytes) + 1);
  while (true) {
    const ssize_t count = ::read(fd.get(), bytes.data() + used, bytes.size() - used);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) Fail(path, "cannot be read", errno);
    used += static_cast<std::size_t>(count);
    if (used > max_bytes) FailAsTooLong(path, max_bytes);
    if (count == 0) break;
    if (used == bytes.size()) bytes.resize(std::min(max_bytes + 1, 2 * bytes.size()));
  }
  bytes.resize(used);
  return bytes;
}

}  // namespace

int UniqueFd::Close() { return ::close(std::exchange(fd_, -1)) == 0 ? 0 : errno; }

UniqueFd OpenForReading(const std::filesystem::path& path) {
  struct stat status {};
  // Looked at first, as opening some devices does something; and again when it is open, as it may be another by then.
  if (::stat(path.c_str(), &status) == 0) CheckIsRegular(status, path);
  UniqueFd fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (!fd.valid()) Fail(path, "cannot be opened", errno);
  if (::fstat(fd.get(), &status) != 0) Fail(path, "cannot be read", errno);
  CheckIsRegular(status, path);
  return fd;
}

std::string ReadFile(const std::filesystem::path& path, std::size_t max_bytes) {
  const UniqueFd fd = OpenForReading(path);
  struct stat status {};
  if (::fstat(fd.get(), &status) != 0) Fail(path, "cannot be read", errno);
  const std::size_t size = static_cast<std::size_t>(std::max<off_t>(status.st_size, 0));
  if (size > max_bytes) FailAsTooLong(path, max_bytes);  // reading what is allowed of it would take seconds
  return ReadAll(fd, path, size, max_bytes);
}

}  // namespace chequer
