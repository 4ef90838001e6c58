#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "capture/recording_writer.h"

namespace chequer::test {

/// Writes a recording of 4 × 2 grey frames, frame i filled with the value i, 10 ms apart from 5 s on, sequence from
/// 100.
inline RecordingInfo WriteSmallRecording(const std::filesystem::path& folder, int frames,
                                         FrameFileKind kind = FrameFileKind::kRaw) {
  RecordingInfo info;
  info.width = 4;
  info.height = 2;
  info.pixel_format = PixelFormat::kMono8;
  info.fps = 100;
  RecordingWriter writer(folder, info, {kind, {}});
  for (int i = 0; i < frames; ++i) {
    Image image(PixelFormat::kMono8, 4, 2);
    for (std::uint8_t& byte : image.bytes()) byte = static_cast<std::uint8_t>(i);
    const std::chrono::microseconds since_first(10'000 * i);
    writer.Add(image.view(), UtcTime(std::chrono::seconds(1'600'000'000)) + since_first,
               MonotonicTime(std::chrono::seconds(5)) + since_first, 100 + static_cast<std::uint64_t>(i));
  }
  return info;
}

}  // namespace chequer::test
