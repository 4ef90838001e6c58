#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "capture/image_file.h"
#include "capture/recording.h"
#include "chequer/detect_trace.h"
#include "chequer/detector_memory.h"
#include "core/convert.h"
#include "core/file.h"
#include "tools/commands.h"
#include "tools/detect_options.h"
#include "tools/diagnosis.h"
#include "tools/explanation.h"

namespace chequer {
namespace {

/// About so wide a picture becomes without --scale.
constexpr int kPictureWidth = 4000;
/// And so many candidates get a panel, where --scale is given.
constexpr int kMostPanels = 60;

/// The options as typed.
struct ExplainRequest {
  std::string file;
  std::string sequence;               ///< a recording, instead of an image
  std::optional<std::int64_t> frame;  ///< of it; the last one where none is named
  std::string out;
  DetectOptions options;
  std::vector<int> region;
  int scale = 0;
  std::optional<int> panels;
};

ImageRegion RegionOf(const std::vector<int>& typed, const ImageView& image) {
  if (typed.empty()) return {0, 0, image.width(), image.height()};
  const ImageRegion region{typed[0], typed[1], typed[2], typed[3]};
  if (region.x < 0 || region.y < 0 || region.width < 1 || region.height < 1 ||
      region.width > image.width() - region.x || region.height > image.height() - region.y)
    throw CLI::ValidationError(
        "--region", fmt::format("{},{},{},{} (x, y, width, height) does not lie in the image of "
                                "{}x{}",
                                region.x, region.y, region.width, region.height, image.width(), image.height()));
  return region;
}

/// An image that is explained.
struct Subject {
  std::string name;
  Image image;
  /// Of a recording, the memory of the frames before.
  std::optional<DetectorMemory> memory{};
  std::chrono::nanoseconds captured{};
};

/// A frame of a recording, with what the detector was taught by those before it.
Subject FrameOf(const ExplainRequest& request, PixelFormat one_channel, const std::optional<ToneCurve>& curve,
                Detector& detector) {
  const Recording recording =
      OpenRecording(request.sequence, {.one_channel = one_channel, .jpeg_colour = JpegColour::kYuv});
  const auto last = static_cast<std::int64_t>(recording.frames.size()) - 1;
  const std::int64_t asked = request.frame.value_or(last);
  if (asked < 0 || asked > last)
    throw CLI::ValidationError("--frame", fmt::format("{} is not in {}: 0 to {}", asked, request.sequence, last));
  Subject subject;
  subject.memory.emplace();
  std::vector<MarkerPose> markers;
  for (std::size_t i = 0; i <= static_cast<std::size_t>(asked); ++i) {
    subject.image = LoadFrame(recording, i);
    subject.captured = recording.frames[i].captured_monotonic.time_since_epoch();
    subject.name = recording.frames[i].file;
    if (static_cast<std::int64_t>(i) < asked)
      detector.Detect(WithToneCurve(subject.image.view(), curve), subject.captured, *subject.memory, markers);
  }
  return subject;
}

void RunExplain(ExplainRequest& request) {
  if (request.file.empty() == request.sequence.empty())
    throw CLI::ValidationError("explain", "needs either an IMAGE or a recording, --sequence DIR");
  TakeSetup(request.options, "explain");
  Detector detector(MakeDetectorOptions(request.options));
  const PixelFormat one_channel = ParseOneChannel(request.options.pixel_format);
  const auto curve = ParseGamma(request.options.gamma);
  CheckRange("--panels", request.panels.value_or(0), 0, 10000);
  Subject subject;
  if (!request.sequence.empty()) {
    subject = FrameOf(request, one_channel, curve, detector);
  } else {
    subject.name = std::filesystem::path(request.file).filename().string();
    subject.image = LoadImage(request.file, {one_channel, JpegColour::kYuv, ToneCurve::Srgb()});
  }
  const ImageView image = WithToneCurve(subject.image.view(), curve);
  CheckCalibrationFits(detector.options(), request.options, subject.name, image);

  Explanation explanation;
  explanation.name = subject.name;
  explanation.region = RegionOf(request.region, image);
  std::vector<MarkerPose> markers;
  DetectTrace trace;
  if (subject.memory)
    detector.Detect(image, subject.captured, *subject.memory, markers, &trace);
  else
    detector.Detect(image, markers, &trace);
  const Image picture = ToBgr(image);
  explanation.image = picture.view();
  explanation.markers = markers;
  explanation.trace = &trace;
  explanation.stats = detector.stats();
  explanation.findings = Diagnose(explanation.image, detector.options(), markers, trace);

  if (!request.out.empty()) {
    if (request.scale == 0 && !request.panels) {
      WriteFileAtomically(request.out, DrawContactSheet(explanation));
    } else {
      const int scale =
          request.scale > 0
              ? request.scale
              : std::clamp((kPictureWidth + explanation.region.width / 2) / explanation.region.width, 1, 4);
      WriteFileAtomically(request.out, DrawExplanation(explanation, scale, request.panels.value_or(kMostPanels)));
    }
  }
  const std::string text = DescribeExplanation(explanation);
  std::fwrite(text.data(), 1, text.size(), stdout);
  if (std::fflush(stdout) != 0) throw std::runtime_error("standard output could not be written to the end");
}

}  // namespace

void AddExplainCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("explain", "Shows what the detector saw in an image, and why a marker is not read");
  // Shared, as the callback outlives this function and std::function copies what it holds.
  const auto request = std::make_shared<ExplainRequest>();
  command->add_option("IMAGE", request->file, "A PNG, JPEG, BMP, PGM or PPM file");
  CLI::Option* sequence =
      command
          ->add_option("--sequence", request->sequence,
                       "Instead of an image: a frame of this recording, begun with what those before it taught")
          ->type_name("DIR");
  command->add_option("--frame", request->frame, "Which one, from 0 on [the last]")->type_name("N")->needs(sequence);
  command->add_option("--out", request->out, "The picture, a PNG; without it, only the list is printed")
      ->type_name("FILE");
  AddDetectOptions(*command, request->options);
  command->add_option("--region", request->region, "Only that part of the image (the whole is searched)")
      ->type_name("X,Y,WIDTH,HEIGHT")
      ->delimiter(',')
      ->expected(4);
  command
      ->add_option("--scale", request->scale,
                   "The whole picture, with so many pixels per image pixel, 1 to 16, instead of one that fits a screen")
      ->type_name("N")
      ->check(CLI::Range(1, 16));
  command
      ->add_option("--panels", request->panels,
                   "In the whole picture, at most so many candidates get a panel of their own [60]")
      ->type_name("N");
  command->footer(
      "Tries all sizes, variants and mirror images, says what would have been found and which option finds it. Prints\n"
      "what became of every group of corners, the likeliest missed marker first, and draws every stage into the image: "
      "peaks,\n"
      "corners, links, boards, and in each cell what it was taken for. Each candidate's panel has the Gaussians of "
      "its\n"
      "luminances and saturations: the two groups of either must stand apart. Places full of contrast where no board "
      "was\n"
      "found, P1, P2, ..., are viewed a second time, for boards seen at a steep slant: their panels have that view.\n\n"
      "Of a board that was found, what is hidden is counted by reason. Cells: outside the image, flat (no lighter or\n"
      "darker than their neighbours), covered (a side without which the border is a marker's), enclosed by such, "
      "beside\n"
      "hidden corners alone, off_colour. Corners: outside, beside hidden cells, flat (hardly any contrast), misfit "
      "(their\n"
      "pixels are no corner's), left_out (without them, the rest fits better), pulled (by what hides their "
      "neighbours).\n\n"
      "What does the camera north see, and what would it not read?\n"
      "  chequer snapshot --config north --out frame.png\n"
      "  chequer explain frame.png --config north --out why.png\n"
      "Why is the marker at (812, 430) not read?\n"
      "  chequer explain frame.png --marker 6x6:secded --region 750,370,130,130 --out why.png\n"
      "Which markers did the frames before lead it to expect, and what became of them?\n"
      "  chequer explain --sequence recording --frame 120 --marker 6x6:secded --out why.png");
  command->callback([request] { RunExplain(*request); });
}

}  // namespace chequer
