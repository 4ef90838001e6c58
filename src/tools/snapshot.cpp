#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>

#include "capture/image_file.h"
#include "capture/recording_writer.h"
#include "core/convert.h"
#include "core/file.h"
#include "tools/commands.h"
#include "tools/source_options.h"

namespace chequer {
namespace {

struct SnapshotRequest {
  SourceRequest source;
  std::string out;
  int skip = 10;
};

/// Waits for the frame after `skip` others.
Frame TakeFrame(FrameSource& source, int skip) {
  constexpr std::chrono::seconds kLongest{10};
  while (true) {
    CaptureResult result = source.Next(kLongest);
    switch (result.status) {
      case CaptureStatus::kFrame:
        if (skip-- > 0) break;
        return std::move(result.frame);
      case CaptureStatus::kCorrupt: break;
      case CaptureStatus::kTimeout: throw std::runtime_error("no frame came from " + source.Describe());
      case CaptureStatus::kDisconnected: throw std::runtime_error("the camera was lost: " + result.message);
      case CaptureStatus::kEnd: throw std::runtime_error("the recording has no more frames; use a smaller --skip");
    }
  }
}

void RunSnapshot(const SnapshotRequest& request) {
  const std::string extension = std::filesystem::path(request.out).extension().string();
  const bool is_png = extension == ".png";
  if (!is_png && extension != ".jpg" && extension != ".jpeg")
    throw CLI::ValidationError("--out", request.out + ": an image is written as .png, .jpg or .jpeg");
  const std::unique_ptr<FrameSource> source = OpenSource(ChooseSource(request.source), "snapshot");
  const Frame frame = TakeFrame(*source, request.skip);
  const bool is_grey = frame.image.format() == PixelFormat::kMono8;
  const Image image = ConvertImage(frame.image, is_grey ? PixelFormat::kMono8 : PixelFormat::kBgr8);
  FrameFileOptions files;
  files.kind = is_png ? FrameFileKind::kPng : FrameFileKind::kJpeg;
  files.jpeg.quality = 95;
  WriteFileAtomically(request.out, EncodeFrame(image.view(), files));
  std::printf("%s: %s\n", request.out.c_str(), source->Describe().c_str());
}

}  // namespace

void AddSnapshotCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("snapshot", "Writes one frame of a camera as an image");
  // Shared, as the callback outlives this function and std::function copies what it holds.
  const auto request = std::make_shared<SnapshotRequest>();
  command->add_option("--out", request->out, "Image to write: .png, .jpg")->type_name("FILE")->required();
  command->add_option("--skip", request->skip, "Frames before it, while exposure and white balance settle")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  AddSourceOptions(*command, request->source);
  command->footer("Is it sharp, are blue and yellow far apart?\n  chequer snapshot --device /dev/video0 --out now.png");
  command->callback([request] { RunSnapshot(*request); });
}

}  // namespace chequer
