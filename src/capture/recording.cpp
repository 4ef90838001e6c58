#include "capture/recording.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <system_error>

#include "capture/recording_text.h"
#include "chequer/check.h"
#include "core/file.h"

namespace chequer {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxIndexBytes = std::size_t{256} << 20;

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

/// Names as people count: runs of digits compare as numbers.
bool NaturallyBefore(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (!IsDigit(a[i]) || !IsDigit(b[j])) {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
      continue;
    }
    while (i < a.size() && a[i] == '0') ++i;
    while (j < b.size() && b[j] == '0') ++j;
    std::size_t a_end = i, b_end = j;
    while (a_end < a.size() && IsDigit(a[a_end])) ++a_end;
    while (b_end < b.size() && IsDigit(b[b_end])) ++b_end;
    if (a_end - i != b_end - j) return a_end - i < b_end - j;
    if (const int order = a.compare(i, a_end - i, b, j, b_end - j); order != 0) return order < 0;
    i = a_end, j = b_end;
  }
  const bool a_is_over = i == a.size(), b_is_over = j == b.size();
  return a_is_over != b_is_over ? a_is_over : a < b;
}

std::vector<fs::path> ImagesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (HasImageExtension(entry->path())) files.push_back(entry->path());
  if (error) throw std::runtime_error(folder.string() + ": cannot be read: " + error.message());
  if (files.empty())
    throw std::runtime_error(folder.string() + ": holds neither " + kRecordingFile +
                             " nor images (PNG, JPEG, BMP, PGM, PPM)");
  std::sort(files.begin(), files.end(),
            [](const auto& a, const auto& b) { return NaturallyBefore(a.filename().string(), b.filename().string()); });
  return files;
}

Recording OpenFolder(const fs::path& folder) {
  Recording recording;
  recording.folder = folder;
  recording.info = ParseRecordingInfo(TomlFile::Load(folder / kRecordingFile));
  const fs::path index = folder / kFrameIndexFile;
  recording.frames = ParseFrameIndex(ReadFile(index, kMaxIndexBytes), index.string());
  if (recording.frames.empty()) throw std::runtime_error(index.string() + ": lists no frame");
  return recording;
}

std::string SizeAndFormat(int width, int height, PixelFormat format) {
  return std::to_string(width) + " x " + std::to_string(height) + " " + std::string(PixelFormatName(format));
}

}  // namespace

Recording OpenRecording(const fs::path& path, const PlainImageOptions& plain) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (error) throw std::runtime_error(path.string() + ": cannot be opened: " + error.message());
  if (!fs::is_directory(status)) return RecordingOfImages({path}, plain);
  if (fs::exists(path / kRecordingFile, error)) return OpenFolder(path);
  return RecordingOfImages(ImagesIn(path), plain);
}

Recording RecordingOfImages(const std::vector<fs::path>& files, const PlainImageOptions& plain) {
  if (files.empty()) throw std::runtime_error("no images are given");
  const Image first = LoadImage(files.front(), {plain.one_channel, plain.jpeg_colour, plain.tone_curve});
  Recording recording;
  recording.info.width = first.width();
  recording.info.height = first.height();
  recording.info.pixel_format = first.format();
  recording.info.tone_curve = plain.tone_curve;
  recording.info.fps = plain.fps;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::chrono::microseconds since_first(std::llround(1e6 * static_cast<double>(i) / plain.fps));
    recording.frames.push_back({files[i].string(), UtcTime(since_first), MonotonicTime(since_first), i});
  }
  return recording;
}

Image LoadFrame(const Recording& recording, std::size_t index) {
  CHEQUER_CHECK(index < recording.frames.size(), "no such frame");
  const RecordingInfo& info = recording.info;
  const fs::path path = recording.folder / recording.frames[index].file;
  if (path.extension() == ".raw")
    return LoadRawImage(path, {info.pixel_format, info.width, info.height, info.tone_curve, info.yuv_range});
  ImageFileOptions options;
  if (IsBayer(info.pixel_format)) options.one_channel = info.pixel_format;
  if (IsYuv(info.pixel_format)) options.jpeg_colour = JpegColour::kYuv;
  options.tone_curve = info.tone_curve;
  Image image = LoadImage(path, options);
  if (image.width() != info.width || image.height() != info.height || image.format() != info.pixel_format)
    throw std::runtime_error(path.string() + ": holds " + SizeAndFormat(image.width(), image.height(), image.format()) +
                             ", the recording is " + SizeAndFormat(info.width, info.height, info.pixel_format));
  return image;
}

}  // namespace chequer
