#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "capture/recording_writer.h"
#include "chequer/camera_file.h"
#include "simulate/random.h"
#include "simulate/truth.h"
#include "tools/commands.h"
#include "tools/marker_options.h"
#include "tools/render_recording.h"
#include "tools/render_request.h"
#include "tools/render_scenario.h"
#include "tools/setup_option.h"

namespace chequer {
namespace {

/// What was written, for the summary.
struct Written {
  std::vector<FrameTruth> truth;
  int markers_cut_off = 0;  ///< over all frames
};

Written WriteRecording(const RenderJob& job, const std::filesystem::path& folder) {
  const Renderer renderer(job.options, job.background);
  RecordingWriter writer(folder, RenderedInfo(job.options, job.fps), job.files);
  WriteCamera(folder / kRenderedCamera, job.options.camera);
  Written written;
  for (int i = 0; i < job.frames; ++i) {
    const auto markers = job.markers_at(job.TimeOf(i));
    const auto number = static_cast<std::uint64_t>(i);
    const Image image = renderer.Render(markers, DeriveSeed(job.seed, number));
    const auto since_first = std::chrono::round<std::chrono::microseconds>(job.TimeOf(i));
    FrameTruth truth;
    truth.file = writer.Add(image.view(), kRenderedUtc + since_first, kRenderedMonotonic + since_first, number);
    truth.markers = TruthOf(markers, job.options.camera);
    written.markers_cut_off += static_cast<int>(markers.size() - truth.markers.size());
    written.truth.push_back(std::move(truth));
  }
  writer.Finish();
  WriteTruth(folder / kRenderedTruth, written.truth);
  return written;
}

void PrintSummary(const RenderJob& job, const Written& written, const std::string& folder) {
  double least = std::numeric_limits<double>::infinity(), most = 0;
  std::size_t markers = 0;
  for (const FrameTruth& frame : written.truth)
    for (const TrueMarker& marker : frame.markers) {
      least = std::min(least, marker.cell_px);
      most = std::max(most, marker.cell_px);
      ++markers;
    }
  const CameraModel& camera = job.options.camera;
  fmt::print("{} frame{} of {}x{} {} with {} markers in all: {}\n", job.frames, job.frames == 1 ? "" : "s",
             camera.width, camera.height, PixelFormatName(job.options.format), markers, folder);
  if (markers > 0) fmt::print("Cells are {:.2f} to {:.2f} px wide at their narrowest.\n", least, most);
  if (least < kSafeCellPx)
    fmt::print("Below {} px markers are missed: use larger ones, a longer lens or more pixels.\n", kSafeCellPx);
  if (written.markers_cut_off > 0)
    fmt::print("{} times a marker stood over the frame's rim; the truth leaves it out.\n", written.markers_cut_off);
}

void RunRender(RenderRequest& request) {
  request.setup = LoadSetup(request.config);
  const RenderJob job = PlanRender(request);
  PrintSummary(job, WriteRecording(job, request.out), request.out);
}

/// A scenario says it all itself, but for the seed that makes others of its kind.
void RunScenario(const CLI::App& command, const RenderRequest& request) {
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    const bool goes_with_it = name == "--scenario" || name == "--out" || name == "--seed";
    if (option->count() > 0 && !goes_with_it)
      throw CLI::ValidationError(name, "does not go with --scenario; say it in " + request.scenario);
  }
  const bool seeded = command.get_option("--seed")->count() > 0;
  RenderScenario(request.scenario, seeded ? std::optional(request.seed) : std::nullopt, request.out);
}

}  // namespace

RecordingInfo RenderedInfo(const RenderOptions& options, double fps) {
  RecordingInfo info;
  info.camera = "simulated";
  info.width = options.camera.width;
  info.height = options.camera.height;
  info.pixel_format = options.format;
  info.tone_curve = options.tone_curve;
  info.yuv_range = options.yuv_range;
  info.fps = fps;
  info.calibration = kRenderedCamera;
  info.truth = kRenderedTruth;
  return info;
}

void AddRenderCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("render", "Renders markers as a camera would see them, with the truth");
  // Shared, as the callback outlives this function and std::function copies what it holds.
  const auto request = std::make_shared<RenderRequest>();
  AddRenderOptions(*command, *request);
  command->footer(
      "Writes a recording: a file a frame, recording.toml, camera.toml and truth.jsonl.\n\n"
      "Will a 40 mm marker be read from 3 m with a 12 mm lens on pixels of 3.45 um?\n"
      "  chequer render --marker 6x6:secded:0.04 --swarm 20 --distance 3 --lens 12 --pixel-pitch 3.45 --out plan\n"
      "  chequer detect --marker 6x6:secded:0.04 --calibration plan/camera.toml plan/*.png\n"
      "A whole lab without a camera: the sheet for the lens, then the room\n"
      "  chequer render --marker 6x6:secded:30mm --ids 0-19 --sheet --frames 40 --fps 5 --out sheet\n"
      "  chequer render --config north --room room.toml --frames 100 --out room\n"
      "A stream in which much happens, and how it fared:\n"
      "  chequer render --scenario /usr/share/doc/chequer/examples/scenarios/reference.toml --out stream\n"
      "  chequer detect --marker 6x6:secded:0.1 --calibration stream/camera.toml --json stream > stream.jsonl\n"
      "  chequer evaluate --phases stream.jsonl --truth stream");
  command->callback([request, command] {
    if (request->scenario.empty())
      RunRender(*request);
    else
      RunScenario(*command, *request);
  });
}

}  // namespace chequer
