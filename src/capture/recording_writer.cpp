#include "capture/recording_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <system_error>

#include "capture/png.h"
#include "capture/recording_text.h"
#include "chequer/check.h"
#include "core/file.h"

namespace chequer {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(const fs::path& path, const std::string& what, int error) {
  throw std::runtime_error(path.string() + ": " + what + ": " + std::strerror(error));
}

const char* Extension(FrameFileKind kind) {
  switch (kind) {
    case FrameFileKind::kPng: return ".png";
    case FrameFileKind::kJpeg: return ".jpg";
    case FrameFileKind::kRaw: return ".raw";
  }
  FailCheck("kind", __FILE__, __LINE__, "no such kind of file");
}

std::vector<std::uint8_t> Packed(const ImageView& image) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(PackedSize(image.format(), image.width(), image.height()));
  const auto shapes = PlaneShapes(image.format(), image.width(), image.height());
  for (int plane = 0; plane < 3; ++plane) {
    const PlaneShape& shape = shapes[static_cast<std::size_t>(plane)];
    for (int y = 0; y < shape.rows; ++y)
      bytes.insert(bytes.end(), image.row(y, plane), image.row(y, plane) + shape.row_bytes);
  }
  return bytes;
}

void CheckInfo(const RecordingInfo& info, FrameFileKind kind) {
  CHEQUER_CHECK(SizeIsValid(info.pixel_format, info.width, info.height), "image size not valid for its format");
  std::string wrong = CheckFrameFiles(kind, info.pixel_format, info.yuv_range);
  if (!wrong.empty()) throw std::runtime_error(wrong);
  if (!(info.fps >= 0.001 && info.fps <= 10000)) throw std::runtime_error("fps must be from 0.001 to 10000");
  for (const std::string& name : {info.calibration, info.truth}) {
    if (!name.empty()) wrong = CheckFileName(name);
    if (!wrong.empty()) throw std::runtime_error(name + ": " + wrong);
  }
}

}  // namespace

std::string CheckFrameFiles(FrameFileKind kind, PixelFormat format, YuvRange range) {
  const std::string name(PixelFormatName(format));
  if (kind == FrameFileKind::kPng && !PngHolds(format))
    return "PNG files hold BGR8, Mono8 and Bayer; " + name + " needs raw files" +
           (JpegHolds(format, range) && format != PixelFormat::kRgb8 ? " or JPEG" : "");
  if (kind == FrameFileKind::kJpeg && (!JpegHolds(format, range) || format == PixelFormat::kRgb8))
    return "JPEG files hold BGR8, Mono8, and YUV420P, YUV422P and YUV444P of full range; " + name +
           (PngHolds(format) ? " needs PNG or raw files" : " needs raw files");
  return {};
}

std::vector<std::uint8_t> EncodeFrame(const ImageView& image, const FrameFileOptions& options) {
  switch (options.kind) {
    case FrameFileKind::kPng: return PngFromImage(image);
    case FrameFileKind::kJpeg: return JpegFromImage(image, options.jpeg);
    case FrameFileKind::kRaw: break;
  }
  return Packed(image);
}

RecordingWriter::RecordingWriter(const fs::path& folder, const RecordingInfo& info, const FrameFileOptions& options)
    : folder_(folder), info_(info), options_(options) {
  CheckInfo(info, options.kind);
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw std::runtime_error(folder.string() + ": cannot be made: " + error.message());
  const fs::path index = folder / kFrameIndexFile;
  if (fs::exists(folder / kRecordingFile, error) || fs::exists(index, error))
    throw std::runtime_error(folder.string() + ": already holds a recording; name a new folder");
  // Frames are numbered files, and must not replace images that are called the same.
  if (!fs::is_empty(folder, error) || error)
    throw std::runtime_error(folder.string() + ": is not empty; name a new folder");
  WriteFileAtomically(folder / kRecordingFile, FormatRecordingInfo(info), Durability::kUnsynced);
  index_ = UniqueFd(::open(index.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (!index_.valid()) Fail(index, "cannot be written", errno);
  AppendLine(std::string(kFrameIndexHeader) + "\n");
}

RecordingWriter::~RecordingWriter() = default;

void RecordingWriter::AppendLine(const std::string& line) {
  // A line that does not fit is taken back, so that a later one, when there is room again, does not follow half a line.
  const ssize_t written = ::pwrite(index_.get(), line.data(), line.size(), index_bytes_);
  if (written != static_cast<ssize_t>(line.size())) {
    const int error = written < 0 ? errno : ENOSPC;
    if (::ftruncate(index_.get(), index_bytes_) != 0) {
      // What is left of it has no line feed, and readers leave that out.
    }
    Fail(folder_ / kFrameIndexFile, "cannot be written", error);
  }
  index_bytes_ += written;
}

std::string RecordingWriter::Add(const ImageView& image, UtcTime captured_utc, MonotonicTime captured_monotonic,
                                 std::uint64_t sequence) {
  const bool same_size = image.width() == info_.width && image.height() == info_.height;
  const bool same_range = !IsYuv(info_.pixel_format) || image.yuv_range() == info_.yuv_range;
  CHEQUER_CHECK(same_size && image.format() == info_.pixel_format && same_range, "a frame unlike its recording");
  return AddEncoded(EncodeFrame(image, options_), captured_utc, captured_monotonic, sequence);
}

std::string RecordingWriter::AddEncoded(std::span<const std::uint8_t> file, UtcTime captured_utc,
                                        MonotonicTime captured_monotonic, std::uint64_t sequence) {
  if (count_ > 0 && (captured_monotonic <= last_.captured_monotonic || sequence <= last_.sequence))
    throw std::runtime_error(folder_.string() + ": capture time and sequence must grow from frame to frame");
  if (count_ == kMaxRecordedFrames)
    throw std::runtime_error(folder_.string() + ": a recording has at most " + std::to_string(kMaxRecordedFrames) +
                             " frames");
  char name[32];
  std::snprintf(name, sizeof name, "%06zu%s", count_, Extension(options_.kind));
  const RecordedFrame frame{name, captured_utc, captured_monotonic, sequence};
  WriteFileAtomically(folder_ / name, file, Durability::kUnsynced);
  AppendLine(FormatFrameLine(frame));
  last_ = frame;
  ++count_;
  return name;
}

void RecordingWriter::Finish() { SyncFolder(folder_); }

}  // namespace chequer
