#include "core/file.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "core/unique_fd.h"

namespace chequer {
namespace {

[[noreturn]] void Fail(const std::filesystem::path& path, const std::string& what, int error) {
  throw std::runtime_error(path.string() + ": " + what + ": " + std::strerror(error));
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
    if (used > max_bytes)
      throw std::runtime_error(path.string() + ": longer than the " + std::to_string(max_bytes) +
                               " bytes allowed here");
    if (count == 0) break;
    if (used == bytes.size()) bytes.resize(std::min(max_bytes + 1, 2 * bytes.size()));
  }
  bytes.resize(used);
  return bytes;
}

/// Writes and makes it last; 0 or an errno.
int WriteAll(UniqueFd fd, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(fd.get(), bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return fd.Close();
}

}  // namespace

int UniqueFd::Close() { return ::close(std::exchange(fd_, -1)) == 0 ? 0 : errno; }

std::string ReadFile(const std::filesystem::path& path, std::size_t max_bytes) {
  const UniqueFd fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!fd.valid()) Fail(path, "cannot be opened", errno);
  struct stat status {};
  if (::fstat(fd.get(), &status) != 0) Fail(path, "cannot be read", errno);
  if (S_ISDIR(status.st_mode)) throw std::runtime_error(path.string() + ": is a folder, not a file");
  return ReadAll(fd, path, static_cast<std::size_t>(std::max<off_t>(status.st_size, 0)), max_bytes);
}

void WriteFileAtomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  std::filesystem::path partial = path;
  partial += ".partial";
  UniqueFd fd(::open(partial.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (!fd.valid()) Fail(path, "cannot be written", errno);
  int error = WriteAll(std::move(fd), bytes);
  if (error == 0 && std::rename(partial.c_str(), path.c_str()) != 0) error = errno;
  if (error == 0) return;
  ::unlink(partial.c_str());
  Fail(path, "cannot be written", error);
}

void WriteFileAtomically(const std::filesystem::path& path, std::string_view text) {
  WriteFileAtomically(path, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

}  // namespace chequer
