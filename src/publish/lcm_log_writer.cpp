#include "publish/lcm_log_writer.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "core/output_file.h"
#include "core/set_aside.h"
#include "publish/lcm_log_events.h"

namespace chequer {
namespace {

/// Another writer that begins at the same time may take the file in between; it keeps it then.
constexpr int kTries = 10;

[[noreturn]] void Fail(const std::filesystem::path& path, const std::string& why) {
  throw std::runtime_error("the log " + path.string() + " cannot be written: " + why);
}

/// Makes this the only writer. Throws where there is another. File systems that know no locks are trusted.
void Lock(const UniqueFd& file, const std::filesystem::path& path) {
  if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    Fail(path, "another program writes it; give each a file of its own");
}

/// Whether the path still leads to that file.
bool IsAt(const std::filesystem::path& path, const struct stat& file) {
  struct stat there {};
  return ::stat(path.c_str(), &there) == 0 && there.st_dev == file.st_dev && there.st_ino == file.st_ino;
}

/// Whether a pipe has room soon: publishing must not hang on who reads it.
bool WaitForReader(const UniqueFd& pipe) {
  pollfd waiting{pipe.get(), POLLOUT, 0};
  return ::poll(&waiting, 1, 100) == 1;
}

/// Events of a log that can be appended to; −1 where it is damaged, or none.
std::int64_t CountEvents(const std::filesystem::path& path) {
  LogEventReader reader(path);
  while (reader.Next()) {
  }
  return reader.damaged() ? -1 : reader.count();
}

}  // namespace

LcmLogWriter::LcmLogWriter(const std::filesystem::path& path, EarlierLog earlier) : path_(ThroughLinks(path)) {
  for (int i = 0; i < kTries; ++i)
    if (Open(earlier)) return;
  Fail(path_, "another program takes its place again and again");
}

/// False where the file was replaced meanwhile.
bool LcmLogWriter::Open(EarlierLog earlier) {
  // Not waiting: a pipe that nobody reads would keep the program for ever.
  file_ = UniqueFd(::open(path_.c_str(), O_WRONLY | O_CREAT | O_NONBLOCK | O_NOCTTY | O_CLOEXEC, 0666));
  struct stat status {};
  if (!file_.valid() || ::fstat(file_.get(), &status) != 0) Fail(path_, std::strerror(errno));
  is_ordinary_ = S_ISREG(status.st_mode);
  if (!is_ordinary_) return true;
  Lock(file_, path_);
  if (!IsAt(path_, status) || ::fstat(file_.get(), &status) != 0) return false;
  if (status.st_size == 0) return true;
  const std::int64_t events = earlier == EarlierLog::kAppend ? CountEvents(path_) : -1;
  if (events >= 0) {
    count_ = events;
    end_ = status.st_size;
    return true;
  }
  const std::filesystem::path aside = SetAside(path_);
  if (set_aside_.empty()) set_aside_ = aside;
  return false;  // and now there is room
}

int LcmLogWriter::WriteAll(std::span<const std::uint8_t> bytes) {
  std::int64_t offset = end_;
  while (!bytes.empty()) {
    const ssize_t count = is_ordinary_ ? ::pwrite(file_.get(), bytes.data(), bytes.size(), offset)
                                       : ::write(file_.get(), bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN && WaitForReader(file_)) continue;
    if (count < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
    offset += count;
  }
  return 0;
}

std::string LcmLogWriter::Write(UtcTime time, const std::string& channel, std::span<const std::uint8_t> data) {
  EncodeLogEvent(count_, time, channel, data, event_);
  if (const int error = WriteAll(event_); error != 0) {
    // What is left of it could not be read, and what follows would be taken for its rest.
    if (is_ordinary_ && ::ftruncate(file_.get(), end_) != 0)
      return std::string(std::strerror(error)) + ", and what is left of a message stays in the log";
    return std::strerror(error);
  }
  end_ += std::ssize(event_);
  ++count_;
  return {};
}

}  // namespace chequer
