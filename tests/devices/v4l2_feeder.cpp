// v4l2_feeder DEVICE RECORDING FPS [MJPEG]: feeds a v4l2loopback device with the frames of a recording, over and over,
// until it is killed: as YUYV, or with the JPEG files that they are.
#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "capture/recording.h"
#include "core/convert.h"
#include "core/file.h"
#include "core/unique_fd.h"

namespace {

using chequer::Image;

[[noreturn]] void Fail(const std::string& what) { throw std::runtime_error(what + ": " + std::strerror(errno)); }

chequer::UniqueFd OpenLoop(const char* device, const chequer::RecordingInfo& info, bool as_jpeg) {
  chequer::UniqueFd fd(open(device, O_RDWR | O_CLOEXEC));
  if (!fd.valid()) Fail(device);
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  format.fmt.pix.width = static_cast<std::uint32_t>(info.width);
  format.fmt.pix.height = static_cast<std::uint32_t>(info.height);
  format.fmt.pix.pixelformat = as_jpeg ? V4L2_PIX_FMT_MJPEG : V4L2_PIX_FMT_YUYV;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  format.fmt.pix.bytesperline = 2 * format.fmt.pix.width;
  format.fmt.pix.sizeimage = format.fmt.pix.bytesperline * format.fmt.pix.height;
  format.fmt.pix.colorspace = V4L2_COLORSPACE_JPEG;  // full range
  if (ioctl(fd.get(), VIDIOC_S_FMT, &format) < 0) Fail("VIDIOC_S_FMT");
  return fd;
}

using Bytes = std::vector<std::uint8_t>;

Bytes FrameBytes(const chequer::Recording& recording, std::size_t index, bool as_jpeg) {
  if (as_jpeg) {
    constexpr std::size_t kMost = std::size_t{16} << 20;
    const std::string file = chequer::ReadFile(recording.folder / recording.frames[index].file, kMost);
    return {file.begin(), file.end()};
  }
  const Image image = chequer::ConvertImage(chequer::LoadFrame(recording, index).view(), chequer::PixelFormat::kYuyv);
  return {image.bytes().begin(), image.bytes().end()};
}

void Run(const char* device, const char* folder, double fps, bool as_jpeg) {
  const chequer::Recording recording = chequer::OpenRecording(folder);
  std::vector<Bytes> frames;
  // A second of it is enough, and soon converted, also on an emulated processor.
  for (std::size_t i = 0; i < std::min<std::size_t>(recording.frames.size(), 20); ++i)
    frames.push_back(FrameBytes(recording, i, as_jpeg));
  const chequer::UniqueFd fd = OpenLoop(device, recording.info, as_jpeg);
  std::printf("feeding %s\n", device);
  std::fflush(stdout);
  auto due = std::chrono::steady_clock::now();
  for (std::size_t i = 0;; ++i) {
    const Bytes& bytes = frames[i % frames.size()];
    if (write(fd.get(), bytes.data(), bytes.size()) < 0) Fail("write");
    due += std::chrono::microseconds(static_cast<std::int64_t>(1e6 / fps));
    std::this_thread::sleep_until(due);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4 && argc != 5) {
    std::fprintf(stderr, "usage: v4l2_feeder DEVICE RECORDING FPS [MJPEG]\n");
    return 2;
  }
  try {
    Run(argv[1], argv[2], std::atof(argv[3]), argc == 5);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "v4l2_feeder: %s\n", error.what());
  }
  return 1;
}
