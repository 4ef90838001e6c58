#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "capture/jpeg.h"
#include "capture/recording.h"
#include "chequer/image.h"
#include "core/unique_fd.h"

namespace chequer {

/// What the frames of a recording are stored as.
enum class FrameFileKind : std::uint8_t { kPng, kJpeg, kRaw };

struct FrameFileOptions {
  FrameFileKind kind = FrameFileKind::kPng;
  JpegOptions jpeg;
};

/// Empty if files of that kind hold that pixel format so that it comes back as it was, else what would be right.
std::string CheckFrameFiles(FrameFileKind kind, PixelFormat format, YuvRange range);

/// The bytes of one frame's file. @pre CheckFrameFiles is empty for it.
std::vector<std::uint8_t> EncodeFrame(const ImageView& image, const FrameFileOptions& options);

/// Writes a recording frame by frame. Each frame is whole or not there, however the program ends (a loss of power may
/// cost the last ones: nothing is forced to the disk before the end).
class RecordingWriter {
 public:
  /// Makes the folder and writes recording.toml. Throws std::runtime_error naming path and cause; also where the folder
  /// is not empty, and where info or file kind do not go together.
  RecordingWriter(const std::filesystem::path& folder, const RecordingInfo& info, const FrameFileOptions& options = {});
  ~RecordingWriter();
  RecordingWriter(RecordingWriter&&) noexcept = default;

  /// Appends a frame and returns its file's name. Throws std::runtime_error naming path and cause (such as a full
  /// disk), and where time or sequence do not grow; the recording then is as it was before.
  /// @pre size, format and range are those of the recording.
  std::string Add(const ImageView& image, UtcTime captured_utc, MonotonicTime captured_monotonic,
                  std::uint64_t sequence);

  /// The same of a frame that is encoded already, so that copying loses nothing.
  /// @pre a file of the recording's kind that holds an image of its size, format and range.
  std::string AddEncoded(std::span<const std::uint8_t> file, UtcTime captured_utc, MonotonicTime captured_monotonic,
                         std::uint64_t sequence);

  /// Forces all frames and the index to the disk. Throws std::runtime_error naming path and cause.
  void Finish();

  std::size_t size() const { return count_; }

 private:
  void AppendLine(const std::string& line);

  std::filesystem::path folder_;
  RecordingInfo info_;
  FrameFileOptions options_;
  UniqueFd index_;
  std::int64_t index_bytes_ = 0;
  std::size_t count_ = 0;
  RecordedFrame last_;
};

}  // namespace chequer
