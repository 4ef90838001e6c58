#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/image_file.h"
#include "chequer/frame.h"
#include "chequer/image.h"

namespace chequer {

// A recording is a folder:
//
//   recording.toml   [recording] with the keys of RecordingInfo, written first
//   frames.csv       "file,utc_us,monotonic_us,sequence", then one line a frame, appended as the frames come
//   000000.png …     a file a frame (PNG, JPEG, or .raw: packed bytes), each written before its line
//
// and, if recording.toml names them, a camera file and a file with the truth. Whatever ends the writing, what is there
// can be read: a last line without its end is a line that was being written, and is left out.

inline constexpr const char* kRecordingFile = "recording.toml";
inline constexpr const char* kFrameIndexFile = "frames.csv";
inline constexpr std::size_t kMaxRecordedFrames = 2'000'000;

/// What all frames of a recording have in common.
struct RecordingInfo {
  std::string camera = "camera";
  int width = 0;  ///< pixels
  int height = 0;
  PixelFormat pixel_format = PixelFormat::kBgr8;
  /// Written as `gamma = 2.2`; left out for sRGB.
  ToneCurve tone_curve = ToneCurve::Srgb();
  YuvRange yuv_range = YuvRange::kFull;
  double fps = 30;          ///< nominal, 0.001..10000
  std::string calibration;  ///< a camera file's name in the folder; may be empty
  std::string truth;        ///< a truth file's name in the folder; may be empty
};

struct RecordedFrame {
  std::string file;                    ///< in the folder, as frames.csv has it
  UtcTime captured_utc{};              ///< when it was captured
  MonotonicTime captured_monotonic{};  ///< of the host that recorded it; grows from frame to frame
  std::uint64_t sequence = 0;          ///< grows from frame to frame; a gap is frames that were lost
};

struct Recording {
  std::filesystem::path folder;  ///< empty for a list of images
  RecordingInfo info;
  std::vector<RecordedFrame> frames;
};

/// What images without a recording.toml do not say themselves.
struct PlainImageOptions {
  double fps = 30;                                ///< times are made up from it, from 0 on
  PixelFormat one_channel = PixelFormat::kMono8;  ///< what grey files hold: kMono8 or a Bayer format
  JpegColour jpeg_colour = JpegColour::kYuv;      ///< what JPEGs are decoded to
  ToneCurve tone_curve = ToneCurve::Srgb();
};

/// Reads recording.toml and frames.csv of a folder; without a recording.toml, the folder's images are the frames, in
/// the order of their names (2.png before 10.png); a single image file is a recording of one frame. No frame is decoded
/// but the first of plain images.
/// Throws std::runtime_error naming file, line, what is wrong and what would be right. File names that leave the folder
/// ("..", "/…") are refused.
Recording OpenRecording(const std::filesystem::path& path, const PlainImageOptions& plain = {});

/// Images as a recording, in the order given. Throws std::runtime_error where there are none or the first is unusable.
Recording RecordingOfImages(const std::vector<std::filesystem::path>& files, const PlainImageOptions& plain = {});

/// The pixels of a frame. Throws std::runtime_error naming the file and the cause, also where its size or format is
/// not the recording's. Any thread. @pre index < recording.frames.size().
Image LoadFrame(const Recording& recording, std::size_t index);

}  // namespace chequer
