#include "core/convert.h"

#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <unordered_map>

#include "chequer/camera_file.h"
#include "core/file.h"
#include "core/suggestion.h"
#include "core/toml_reader.h"
#include "simulate/truth.h"
#include "tools/calibrate.h"
#include "tools/commands.h"
#include "tools/convert_job.h"
#include "tools/convert_log.h"
#include "tools/log_plot.h"
#include "tools/number_check.h"

namespace chequer {
namespace {

namespace fs = std::filesystem;

/// Whether a file begins as a kind does: names may lie, and what is copied must be what it says.
bool IsFileOfKind(const std::string& bytes, FrameFileKind kind) {
  switch (kind) {
    case FrameFileKind::kPng: return bytes.starts_with("\x89PNG");
    case FrameFileKind::kJpeg: return bytes.starts_with("\xff\xd8");
    case FrameFileKind::kRaw: return true;
  }
  return false;
}

/// The bytes of the file that a frame becomes. Throws std::runtime_error naming the file that cannot be read.
std::vector<std::uint8_t> ConvertFrame(const ConvertJob& job, std::size_t index) {
  const Image image = LoadFrame(job.input, index);
  const fs::path file = job.input.folder / job.input.frames[index].file;
  if (job.may_copy_files && KindOf(file) == job.files.kind) {
    const std::string bytes = ReadFile(file, kMaxImageFileBytes);
    if (IsFileOfKind(bytes, job.files.kind)) return {bytes.begin(), bytes.end()};
  }
  return EncodeFrame(ConvertImage(image.view(), job.info.pixel_format, job.info.yuv_range).view(), job.files);
}

using NewNames = std::unordered_map<std::string, std::string>;  ///< by the names in the input

struct Converted {
  NewNames names;
  int written = 0;
  int failed = 0;
};

/// Hands each frame that can be read to `write`; complains of the others.
template <typename Write>
Converted ConvertFrames(const ConvertJob& job, const Write& write) {
  Converted converted;
  for (std::size_t i = job.first; i <= job.last; i += job.every) {
    std::vector<std::uint8_t> bytes;
    try {
      bytes = ConvertFrame(job, i);
    } catch (const std::runtime_error& error) {
      std::fprintf(stderr, "chequer convert: %s\n", error.what());
      ++converted.failed;
      continue;
    }
    converted.names.emplace(job.input.frames[i].file, write(bytes, job.input.frames[i]));
    ++converted.written;
  }
  return converted;
}

void CopyTruth(const fs::path& from, const fs::path& to, const NewNames& names) {
  std::vector<FrameTruth> kept;
  for (FrameTruth& frame : ReadTruth(from)) {
    const auto name = names.find(frame.file);
    if (name == names.end()) continue;
    frame.file = name->second;
    kept.push_back(std::move(frame));
  }
  WriteTruth(to, kept);
}

Converted WriteRecording(const ConvertJob& job) {
  // Read before anything is written: a bad camera file must not leave half a recording behind.
  if (job.calibration) LoadCamera(*job.calibration);
  RecordingWriter writer(job.out, job.info, job.files);
  if (job.calibration) WriteFileAtomically(job.out / job.info.calibration, ReadFile(*job.calibration, kMaxTomlBytes));
  Converted converted = ConvertFrames(job, [&](const std::vector<std::uint8_t>& bytes, const RecordedFrame& frame) {
    return writer.AddEncoded(bytes, frame.captured_utc, frame.captured_monotonic, frame.sequence);
  });
  writer.Finish();
  if (job.truth) CopyTruth(*job.truth, job.out / job.info.truth, converted.names);
  return converted;
}

Converted WriteImages(const ConvertJob& job) {
  std::error_code error;
  fs::create_directories(job.out, error);
  if (error) throw std::runtime_error(job.out.string() + ": cannot be made: " + error.message());
  if (!fs::is_empty(job.out, error) || error)
    throw std::runtime_error(job.out.string() + ": is not empty; name a new folder");
  std::size_t count = 0;
  const Converted converted = ConvertFrames(job, [&](const std::vector<std::uint8_t>& bytes, const RecordedFrame&) {
    const char* extension = job.files.kind == FrameFileKind::kPng ? "png" : "jpg";
    const std::string name = fmt::format("{:06}.{}", count++, extension);
    WriteFileAtomically(job.out / name, bytes, Durability::kUnsynced);
    return name;
  });
  SyncFolder(job.out);
  return converted;
}

Converted WriteOneImage(const ConvertJob& job) {
  return ConvertFrames(job, [&](const std::vector<std::uint8_t>& bytes, const RecordedFrame&) {
    WriteFileAtomically(job.out, bytes);
    return job.out.string();
  });
}

/// A log has no frames to choose or to change.
void CheckLogOptions(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options())
    if (option->count() > 0 && option->get_name() != "input" && option->get_name() != "--out" &&
        option->get_name() != "--stream" && option->get_name() != "--plot")
      throw CLI::ValidationError(option->get_name(), "is for recordings and images, the input is an LCM log");
}

LogStream ParseStream(const std::optional<std::string>& word) {
  if (!word) return LogStream::kAll;
  if (*word == "poses") return LogStream::kPoses;
  if (*word == "robots") return LogStream::kRobots;
  if (*word == "tracks") return LogStream::kTracks;
  throw CLI::ValidationError("--stream", *word + ": must be one of poses, robots, tracks" +
                                             DidYouMean(*word, WordsOf("poses, robots, tracks")));
}

void RunConvert(const CLI::App& command, const ConvertRequest& request) {
  if (request.out.empty() && request.plot.empty())
    throw CLI::ValidationError("--out", "is missing: where to write what is converted");
  if (!request.plot.empty()) CheckPngName("--plot", request.plot);
  if (request.inputs.size() == 1 && IsLcmLog(request.inputs.front())) {
    CheckLogOptions(command);
    const LogStream stream = ParseStream(request.stream);
    if (!request.plot.empty()) PlotLog(request.inputs.front(), request.plot, stream);
    if (!request.out.empty()) ConvertLog(request.inputs.front(), request.out, stream);
    return;
  }
  if (!request.plot.empty()) throw CLI::ValidationError("--plot", "is for LCM logs; the input is none");
  if (request.out.empty()) throw CLI::ValidationError("--out", "is missing: where to write what is converted");
  if (request.stream) throw CLI::ValidationError("--stream", "is for LCM logs; the input is none");
  const ConvertJob job = PlanConvert(request);
  Converted converted;
  switch (job.target) {
    case ConvertTarget::kRecording: converted = WriteRecording(job); break;
    case ConvertTarget::kImages: converted = WriteImages(job); break;
    case ConvertTarget::kOneImage: converted = WriteOneImage(job); break;
  }
  fmt::print("{} frame{} of {}x{} {}: {}\n", converted.written, converted.written == 1 ? "" : "s", job.info.width,
             job.info.height, PixelFormatName(job.info.pixel_format), request.out);
  if (converted.failed > 0) throw CLI::RuntimeError(kExitInput);
}

void AddOptions(CLI::App& command, ConvertRequest& request) {
  command.add_option("input", request.inputs, "A recording, a folder of images, images, or an LCM log")->required();
  command.add_option("--out", request.out,
                     "Folder of the new recording; or an image's name, .png or .jpg; of a log: .csv or .jsonl");
  command
      .add_option("--plot", request.plot,
                  "Of a log: draw its tracks (else its robots, else its poses) from above, and their speeds, .png")
      ->type_name("FILE");
  command
      .add_option("--stream", request.stream,
                  "Of a log only these: poses, robots or tracks [all; a .csv, which holds one kind: poses]")
      ->type_name("S");
  command.add_flag("--images", request.images_only, "Write a folder of images alone, without recording.toml");
  command.add_option("--frames", request.frames, "Only these, counted from 0, both included")->type_name("FIRST-LAST");
  command.add_option("--every", request.every, "Only each N-th of them")
      ->check(IsWhole())
      ->type_name("N")
      ->capture_default_str();

  const char* frames = "Frames that are written";
  command.add_option("--pixel-format", request.pixel_format, PixelFormatNames() + " [as before]")
      ->type_name("F")
      ->group(frames);
  command.add_option("--yuv-range", request.yuv_range, "full or limited [as before]")->type_name("R")->group(frames);
  command.add_option("--files", request.files, "png, jpeg or raw [as before, where that holds the pixel format]")
      ->type_name("KIND")
      ->group(frames);
  command.add_option("--quality", request.quality, "Of JPEG, 1..100 [90]")->type_name("Q")->group(frames);
  command.add_option("--chroma", request.chroma, "Sharing of chroma in JPEG: 444, 422 or 420 [420]")
      ->type_name("C")
      ->group(frames);
  command.add_option("--camera", request.camera, "Name in the recording [as before]")->type_name("NAME")->group(frames);
  command.add_option("--calibration", request.calibration, "Camera file to put into the recording [as before]")
      ->type_name("FILE")
      ->group(frames);

  const char* plain = "Images without a recording.toml";
  command.add_option("--fps", request.fps, "Frames a second [30]")->group(plain);
  command.add_option("--one-channel", request.one_channel, "What grey images hold: Mono8, BayerRG8, … [Mono8]")
      ->type_name("F")
      ->group(plain);
  command.add_option("--gamma", request.gamma, "Curve of the values instead of sRGB; 1 is linear")->group(plain);
}

}  // namespace

void AddConvertCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("convert", "Converts recordings and images into each other, and logs of poses into text");
  // Shared, as the callback outlives this function and std::function copies what it holds.
  const auto request = std::make_shared<ConvertRequest>();
  AddOptions(*command, *request);
  command->footer(
      "Times, sequence numbers, calibration and truth are kept. Files whose kind and pixel format stay are copied as\n"
      "they are. A frame that cannot be read is named and left out; the status is then 1.\n\n"
      "Images of a webcam as a recording, frames 100 to 199 of a recording as PNG, raw Bayer made colour, poses that\n"
      "lcm-logger kept as a table:\n"
      "  chequer convert photos --fps 25 --calibration camera.toml --out swarm\n"
      "  chequer convert swarm --frames 100-199 --images --out pictures\n"
      "  chequer convert raw_00000.png --one-channel BayerRG8 --pixel-format BGR8 --out colour.png\n"
      "  chequer convert lcmlog-2024-05-01.00 --out poses.csv\n"
      "  chequer convert lcmlog-2024-05-01.00 --plot tracks.png\n"
      "  chequer convert lcmlog-2024-05-01.00 --stream tracks --out tracks.csv");
  command->callback([request, command] { RunConvert(*command, *request); });
}

}  // namespace chequer
