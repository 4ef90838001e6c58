#include "support/fake_v4l2.h"

#include <linux/videodev2.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdarg>
#include <cstring>
#include <deque>
#include <fstream>
#include <mutex>
#include <stdexcept>

namespace chequer::test {
namespace {

constexpr std::uint32_t kWidth = 1920, kHeight = 1080, kBytes = 2 * kWidth * kHeight;
constexpr std::uint32_t kMostBuffers = 8;

/// The driver behind the functions of libv4l2, which know it by nothing but their names.
struct Driver {
  std::mutex mutex;
  int wake = -1;  ///< readable while a filled buffer waits
  std::array<void*, kMostBuffers> memory{};
  std::deque<std::uint32_t> filled;
  FakeV4l2Frame next;
  bool is_unplugged = false;
};

/// Global, as functions of C know no other way to it.
Driver* driver = nullptr;

int Fail(int error) {
  errno = error;
  return -1;
}

template <typename Item>
int First(const Item& item) {
  return item.index == 0 ? 0 : Fail(EINVAL);
}

int Describe(unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& capability = *static_cast<v4l2_capability*>(argument);
      std::memcpy(capability.driver, "fake", 5);
      std::memcpy(capability.card, "Fake", 5);
      capability.capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
      return 0;
    }
    case VIDIOC_ENUM_FMT: {
      auto& format = *static_cast<v4l2_fmtdesc*>(argument);
      format.pixelformat = V4L2_PIX_FMT_YUYV;
      return First(format);
    }
    case VIDIOC_ENUM_FRAMESIZES: {
      auto& size = *static_cast<v4l2_frmsizeenum*>(argument);
      size.type = V4L2_FRMSIZE_TYPE_DISCRETE;
      size.discrete = {kWidth, kHeight};
      return First(size);
    }
    case VIDIOC_ENUM_FRAMEINTERVALS: {
      auto& interval = *static_cast<v4l2_frmivalenum*>(argument);
      interval.type = V4L2_FRMIVAL_TYPE_DISCRETE;
      interval.discrete = {1, 60};
      return First(interval);
    }
    case VIDIOC_G_FMT:
    case VIDIOC_S_FMT: {
      v4l2_pix_format& format = static_cast<v4l2_format*>(argument)->fmt.pix;
      format.width = kWidth;
      format.height = kHeight;
      format.pixelformat = V4L2_PIX_FMT_YUYV;
      format.bytesperline = 2 * kWidth;
      format.sizeimage = kBytes;
      return 0;
    }
    case VIDIOC_S_PARM: static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe = {1, 60}; return 0;
    default: return Fail(ENOTTY);
  }
}

int Queue(const v4l2_buffer& buffer) {
  driver->filled.push_back(buffer.index);
  const std::uint64_t one = 1;
  return write(driver->wake, &one, sizeof one) == sizeof one ? 0 : -1;
}

int Dequeue(v4l2_buffer& buffer) {
  if (driver->filled.empty()) return Fail(EAGAIN);
  buffer.index = driver->filled.front();
  driver->filled.pop_front();
  std::uint64_t count = 0;
  if (driver->filled.empty() && read(driver->wake, &count, sizeof count) < 0) return -1;
  buffer.bytesused = kBytes - driver->next.bytes_left_out;
  buffer.sequence = driver->next.sequence++;
  buffer.flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | (driver->next.is_damaged ? V4L2_BUF_FLAG_ERROR : 0u);
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  buffer.timestamp = {now.tv_sec, now.tv_nsec / 1000};
  return 0;
}

int Stream(unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_REQBUFS: {
      auto& buffers = *static_cast<v4l2_requestbuffers*>(argument);
      buffers.count = std::min(buffers.count, kMostBuffers);
      return 0;
    }
    case VIDIOC_QUERYBUF: {
      auto& buffer = *static_cast<v4l2_buffer*>(argument);
      buffer.length = kBytes;
      buffer.m.offset = buffer.index;
      return 0;
    }
    case VIDIOC_QBUF: return Queue(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_DQBUF: return Dequeue(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON: return 0;
    case VIDIOC_STREAMOFF: driver->filled.clear(); return 0;
    default: return Describe(request, argument);
  }
}

}  // namespace

FakeV4l2::FakeV4l2() {
  if (driver != nullptr) throw std::logic_error("there is a fake driver already");
  const std::filesystem::path entry = folder_ / "sys/class/video4linux/video0";
  std::filesystem::create_directories(entry);
  std::ofstream(entry / "name") << "Fake\n";
  std::ofstream(entry / "index") << "0\n";
  std::filesystem::create_directories(folder_ / "dev");
  // A device of characters that everybody may open.
  std::filesystem::create_symlink("/dev/null", folder_ / "dev/video0");
  driver = new Driver;
}

FakeV4l2::~FakeV4l2() {
  for (void* memory : driver->memory)
    if (memory != nullptr) munmap(memory, kBytes);
  delete driver;
  driver = nullptr;
}

V4l2Roots FakeV4l2::Roots() const { return {folder_ / "sys", folder_ / "dev"}; }

void FakeV4l2::Say(const FakeV4l2Frame& frame) {
  const std::lock_guard lock(driver->mutex);
  driver->next = frame;
}

void FakeV4l2::Unplug() {
  const std::lock_guard lock(driver->mutex);
  driver->is_unplugged = true;
}

bool FakeV4l2::Owns(const void* address) const {
  const auto* byte = static_cast<const std::uint8_t*>(address);
  return std::any_of(driver->memory.begin(), driver->memory.end(), [&](const void* memory) {
    const auto* begin = static_cast<const std::uint8_t*>(memory);
    return begin != nullptr && byte >= begin && byte < begin + kBytes;
  });
}

std::size_t FakeV4l2::held() const {
  const std::lock_guard lock(driver->mutex);
  return driver->filled.size();
}

}  // namespace chequer::test

// libv4l2's own names: what the program defines comes before what its libraries do.
extern "C" {

int v4l2_fd_open(int fd, int /*flags*/) {
  using chequer::test::driver;
  driver->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (driver->wake < 0 || dup2(driver->wake, fd) < 0) return -1;
  return fd;
}

int v4l2_close(int fd) {
  close(chequer::test::driver->wake);
  return close(fd);
}

int v4l2_ioctl(int /*fd*/, unsigned long request, ...) {
  va_list arguments;
  va_start(arguments, request);
  void* argument = va_arg(arguments, void*);
  va_end(arguments);
  using chequer::test::driver;
  const std::lock_guard lock(driver->mutex);
  if (driver->is_unplugged) return chequer::test::Fail(ENODEV);
  return chequer::test::Stream(request, argument);
}

void* v4l2_mmap(void* /*start*/, size_t length, int protection, int /*flags*/, int /*fd*/, int64_t offset) {
  void*& memory = chequer::test::driver->memory.at(static_cast<std::size_t>(offset));
  if (memory == nullptr) memory = mmap(nullptr, length, protection, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  return memory;
}

int v4l2_munmap(void* /*start*/, size_t /*length*/) { return 0; }

}  // extern "C"
