#include "core/output_file.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <sys/vfs.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace chequer {
namespace {

namespace fs = std::filesystem;

/// As the kernel's own limit.
constexpr int kMostLinks = 40;

/// Throws what the last system call failed with; callers put the file's name to it.
[[noreturn]] void ThrowErrno() { throw std::system_error(errno, std::generic_category()); }

fs::path FolderOf(const fs::path& path) { return path.has_parent_path() ? path.parent_path() : fs::path("."); }

/// What is at a path, through links; nothing where there is nothing.
std::optional<struct stat> Status(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) return status;
  if (errno == ENOENT) return std::nullopt;
  ThrowErrno();
}

/// Whether a link names an open file of a process (/proc/self/fd/1), which no other file can take the place of.
bool NamesAnOpenFile(const fs::path& path) {
  fs::path at = path;
  for (int i = 0; i < kMostLinks && fs::is_symlink(at); ++i) {
    struct statfs file_system {};
    if (::statfs(FolderOf(at).c_str(), &file_system) == 0 && file_system.f_type == PROC_SUPER_MAGIC) return true;
    const fs::path to = fs::read_symlink(at);
    at = to.is_absolute() ? to : FolderOf(at) / to;
  }
  return false;
}

/// Whether a file is made anew and takes the place of what is there; otherwise it is written into.
bool IsReplaced(const fs::path& path, const std::optional<struct stat>& status) {
  return !status || (S_ISREG(status->st_mode) && !NamesAnOpenFile(path));
}

std::string RandomName() {
  std::uint64_t number = 0;
  if (::getrandom(&number, sizeof number, 0) != sizeof number) ThrowErrno();
  char name[48];
  std::snprintf(name, sizeof name, ".chequer-%016llx.partial", static_cast<unsigned long long>(number));
  return name;
}

/// Gives a new file the owner and the mode of the one that it will replace. The owner where the system allows it: it
/// lets only root give files away.
void TakeAfter(int fd, const struct stat& before) {
  struct stat status {};
  if (::fstat(fd, &status) != 0) ThrowErrno();
  if (status.st_gid != before.st_gid && ::fchown(fd, static_cast<uid_t>(-1), before.st_gid) != 0 && errno != EPERM)
    ThrowErrno();
  if (status.st_uid != before.st_uid && ::fchown(fd, before.st_uid, static_cast<gid_t>(-1)) != 0 && errno != EPERM)
    ThrowErrno();
  if (::fchmod(fd, before.st_mode & 0777) != 0) ThrowErrno();
}

/// Opens what is written into. A pipe that nobody reads is an error: a daemon would wait for a reader for ever.
UniqueFd OpenAtOnce(const fs::path& path, SlowReader slow_reader) {
  // At its end: an open file may have been written to before.
  constexpr int kFlags = O_WRONLY | O_APPEND;
  UniqueFd fd(::open(path.c_str(), kFlags | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (!fd.valid()) ThrowErrno();
  if (slow_reader == SlowReader::kWaitedFor && ::fcntl(fd.get(), F_SETFL, kFlags) != 0) ThrowErrno();
  return fd;
}

void SyncName(const fs::path& folder) {
  const UniqueFd fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  // A folder that lets nobody read it, and file systems that cannot: the file itself is safe all the same.
  if (fd.valid() && ::fsync(fd.get()) != 0 && errno == EIO) ThrowErrno();
}

}  // namespace

fs::path ThroughLinks(const fs::path& path) {
  fs::path at = path;
  for (int i = 0; i <= kMostLinks; ++i) {
    if (!fs::is_symlink(at)) return at;
    const fs::path to = fs::read_symlink(at);
    at = to.is_absolute() ? to : FolderOf(at) / to;
  }
  throw std::runtime_error(path.string() + ": " + std::strerror(ELOOP));
}

std::string WhyNotWritable(const fs::path& path) {
  try {
    const std::optional<struct stat> status = Status(path);
    if (status && S_ISDIR(status->st_mode)) return std::strerror(EISDIR);
    if (status && ::faccessat(AT_FDCWD, path.c_str(), W_OK, AT_EACCESS) != 0) return std::strerror(errno);
    if (!IsReplaced(path, status)) return {};
    const fs::path folder = FolderOf(ThroughLinks(path));
    if (::faccessat(AT_FDCWD, folder.c_str(), W_OK | X_OK, AT_EACCESS) == 0) return {};
    return "there is no folder " + folder.string() + " that lets you";
  } catch (const std::system_error& error) {
    return error.code().message();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

OutputFile::OutputFile(const fs::path& path, SlowReader slow_reader) : path_(path) {
  try {
    const std::optional<struct stat> status = Status(path);
    if (status && S_ISDIR(status->st_mode)) Fail(EISDIR);
    if (!IsReplaced(path, status)) {
      fd_ = OpenAtOnce(path, slow_reader);
      return;
    }
    // A file that is protected against writing is not to be replaced either.
    if (status && ::faccessat(AT_FDCWD, path.c_str(), W_OK, AT_EACCESS) != 0) ThrowErrno();
    target_ = ThroughLinks(path);
    // The mode is no wider than the file's before, at any time.
    const mode_t mode = status ? status->st_mode & 0700 : 0666;
    do {
      partial_ = FolderOf(target_) / RandomName();
      fd_ = UniqueFd(::open(partial_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode));
    } while (!fd_.valid() && errno == EEXIST);
    if (!fd_.valid()) {
      partial_.clear();
      ThrowErrno();
    }
    if (status) TakeAfter(fd_.get(), *status);
  } catch (const std::system_error& error) {
    if (!partial_.empty()) ::unlink(partial_.c_str());
    Fail(error.code().value());
  }
}

OutputFile::~OutputFile() {
  if (!partial_.empty()) ::unlink(partial_.c_str());
}

void OutputFile::Fail(int error) const { FailAs(std::strerror(error)); }

void OutputFile::FailAs(const char* why) const {
  throw std::runtime_error(path_.string() + ": cannot be written: " + why);
}

void OutputFile::Write(std::span<const std::uint8_t> bytes) {
  if (buffered_ + bytes.size() > buffer_.size()) Flush();
  if (bytes.size() > buffer_.size()) return WriteThrough(bytes);
  std::memcpy(buffer_.data() + buffered_, bytes.data(), bytes.size());
  buffered_ += bytes.size();
}

void OutputFile::Write(std::string_view text) {
  Write({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

void OutputFile::Flush() { WriteThrough(std::span(buffer_).first(std::exchange(buffered_, 0))); }

void OutputFile::WriteThrough(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(fd_.get(), bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) FailAs("its reader has not read what was written before");
    if (count < 0) Fail(errno);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
}

void OutputFile::Finish(Durability durability) {
  Flush();
  const bool is_replaced = !partial_.empty();
  const bool is_synced = is_replaced && durability == Durability::kSynced;
  if (is_synced && ::fsync(fd_.get()) != 0 && errno != EINVAL) Fail(errno);
  if (const int error = fd_.Close(); error != 0) Fail(error);
  if (!is_replaced) return;
  if (std::rename(partial_.c_str(), target_.c_str()) != 0) Fail(errno);
  partial_.clear();
  try {
    if (is_synced) SyncName(FolderOf(target_));
  } catch (const std::system_error& error) {
    Fail(error.code().value());
  }
}

void WriteFileAtomically(const fs::path& path, std::span<const std::uint8_t> bytes, Durability durability) {
  OutputFile file(path);
  file.Write(bytes);
  file.Finish(durability);
}

void WriteFileAtomically(const fs::path& path, std::string_view text, Durability durability) {
  WriteFileAtomically(path, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, durability);
}

void WriteWithoutWaiting(const fs::path& path, std::string_view text, Durability durability) {
  OutputFile file(path, SlowReader::kRefused);
  file.Write(text);
  file.Finish(durability);
}

void SyncFolder(const fs::path& folder) {
  const UniqueFd fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!fd.valid() || ::syncfs(fd.get()) != 0)
    throw std::runtime_error(folder.string() + ": cannot be written: " + std::strerror(errno));
}

}  // namespace chequer
