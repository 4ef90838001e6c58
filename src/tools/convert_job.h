#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/recording.h"
#include "capture/recording_writer.h"

namespace chequer {

/// The options of `chequer convert`, as typed.
struct ConvertRequest {
  std::vector<std::string> inputs;  ///< a recording, a folder of images, or images
  std::string out;
  std::string plot;                   ///< of a log: a picture
  std::optional<std::string> stream;  ///< of an LCM log: poses, robots, tracks
  bool images_only = false;
  std::optional<std::string> files;         ///< png, jpeg, raw
  std::optional<std::string> pixel_format;  ///< of what is written
  std::optional<std::string> yuv_range;     ///< full, limited
  std::optional<int> quality;
  std::optional<std::string> chroma;  ///< 444, 422, 420
  std::string frames;                 ///< FIRST-LAST or one number, from 0; empty: all
  std::size_t every = 1;
  std::optional<double> fps;  // these three: of images without a recording.toml
  std::optional<std::string> one_channel;
  std::optional<double> gamma;
  std::optional<std::string> camera;
  std::optional<std::string> calibration;  ///< a camera file
};

/// Where the frames go.
enum class ConvertTarget : std::uint8_t {
  kRecording,  ///< a folder with recording.toml
  kImages,     ///< a folder of images alone
  kOneImage,   ///< one image file
};

/// What is to be done, checked.
struct ConvertJob {
  Recording input;
  std::size_t first = 0;
  std::size_t last = 0;  ///< included
  std::size_t every = 1;
  ConvertTarget target = ConvertTarget::kRecording;
  std::filesystem::path out;
  RecordingInfo info;  ///< of what is written
  FrameFileOptions files;
  bool may_copy_files = false;                       ///< input files of the same kind need not be encoded anew
  std::optional<std::filesystem::path> calibration;  ///< goes into the recording
  std::optional<std::filesystem::path> truth;        ///< of the input; its frames get their new names
};

/// Opens the input and settles what to do. Throws CLI::ValidationError naming the option, what is wrong and what would
/// be right; std::runtime_error where the input cannot be read.
ConvertJob PlanConvert(const ConvertRequest& request);

/// The kind of a frame file, by its name: PNG where it is no other that is written here.
FrameFileKind KindOf(const std::filesystem::path& file);

}  // namespace chequer
