#include "lens/bounded_search.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <opencv2/core/utility.hpp>
#include <system_error>

#include "core/unique_fd.h"

namespace chequer {
namespace {

bool WriteAll(int fd, const void* data, std::size_t size) {
  const auto* bytes = static_cast<const std::byte*>(data);
  while (size > 0) {
    const ssize_t count = write(fd, bytes, size);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    bytes += count;
    size -= static_cast<std::size_t>(count);
  }
  return true;
}

[[noreturn]] void Search(int fd, const std::function<std::vector<cv::Point2f>()>& search) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  // OpenCV's threads are not there in a forked process.
  cv::setNumThreads(0);
  bool done = false;
  try {
    const std::vector<cv::Point2f> found = search();
    const std::uint64_t count = found.size();
    done = WriteAll(fd, &count, sizeof count) && WriteAll(fd, found.data(), count * sizeof(cv::Point2f));
  } catch (...) {
    // Whatever it is, nothing was found; the status says so.
  }
  _exit(done ? 0 : 1);
}

/// Reads until the other end is closed or the time is over; whether it was closed.
bool ReadUntil(std::chrono::steady_clock::time_point end, int fd, std::vector<std::byte>& bytes) {
  std::byte buffer[4096];
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    pollfd readable{fd, POLLIN, 0};
    const int ready = left.count() > 0 ? poll(&readable, 1, static_cast<int>(left.count())) : 0;
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    const ssize_t count = read(fd, buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return count == 0;
    bytes.insert(bytes.end(), buffer, buffer + count);
  }
}

std::vector<cv::Point2f> PointsOf(const std::vector<std::byte>& bytes) {
  std::uint64_t count = 0;
  if (bytes.size() < sizeof count) return {};
  std::memcpy(&count, bytes.data(), sizeof count);
  if ((bytes.size() - sizeof count) / sizeof(cv::Point2f) != count) return {};
  std::vector<cv::Point2f> points(count);
  if (count > 0) std::memcpy(points.data(), bytes.data() + sizeof count, count * sizeof(cv::Point2f));
  return points;
}

}  // namespace

std::optional<std::vector<cv::Point2f>> SearchWithin(std::chrono::milliseconds limit,
                                                     const std::function<std::vector<cv::Point2f>()>& search) {
  const auto end = std::chrono::steady_clock::now() + limit;
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  UniqueFd from(ends[0]), to(ends[1]);
  const pid_t child = fork();
  if (child < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (child == 0) Search(to.get(), search);
  to = UniqueFd();
  std::vector<std::byte> bytes;
  const bool ended = ReadUntil(end, from.get(), bytes);
  if (!ended) kill(child, SIGKILL);
  while (waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
  }
  if (!ended) return std::nullopt;
  return PointsOf(bytes);
}

}  // namespace chequer
