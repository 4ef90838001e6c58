#include "tools/render_scenario.h"

#include <fmt/core.h>

#include "capture/recording_writer.h"
#include "chequer/camera_file.h"
#include "simulate/stream.h"
#include "tools/render_recording.h"

namespace chequer {
namespace {

/// PNG where it can be: anything opens it.
FrameFileOptions FilesFor(const RenderOptions& options) {
  FrameFileOptions files;
  if (!CheckFrameFiles(files.kind, options.format, options.yuv_range).empty()) files.kind = FrameFileKind::kRaw;
  return files;
}

std::vector<FrameTruth> WriteFrames(const Stream& stream, const std::filesystem::path& folder) {
  const ScenarioCamera& camera = stream.scenario().camera;
  RecordingWriter writer(folder, RenderedInfo(camera.render, camera.fps), FilesFor(camera.render));
  WriteCamera(folder / kRenderedCamera, camera.render.camera);
  std::vector<FrameTruth> truth;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const auto since_first =
        std::chrono::round<std::chrono::microseconds>(std::chrono::duration<double>(stream.plan(i).time_s));
    FrameTruth frame = stream.Truth(i);
    frame.file = writer.Add(stream.Draw(i).view(), kRenderedUtc + since_first, kRenderedMonotonic + since_first,
                            stream.plan(i).sequence);
    truth.push_back(std::move(frame));
  }
  writer.Finish();
  WriteTruth(folder / kRenderedTruth, truth);
  return truth;
}

void PrintPhases(const Scenario& scenario, const std::vector<FrameTruth>& truth) {
  for (const Phase& phase : scenario.phases) {
    int frames = 0;
    double motion_px = 0;
    for (const FrameTruth& frame : truth) {
      if (frame.phase != phase.name) continue;
      ++frames;
      for (const TrueMarker& marker : frame.markers) motion_px = std::max(motion_px, marker.motion_px);
    }
    if (frames > 0)
      fmt::print("  {:20}{:>6} frames, motion up to {:.1f} px\n", phase.name, frames, motion_px);
    else
      fmt::print("  {:20}{:>6} frames' time without any\n", phase.name, phase.frames);
  }
}

}  // namespace

void RenderScenario(const std::filesystem::path& file, std::optional<std::uint64_t> seed,
                    const std::filesystem::path& folder) {
  Scenario scenario = LoadScenario(file);
  if (seed) scenario.seed = *seed;
  const Stream stream(std::move(scenario));
  const std::vector<FrameTruth> truth = WriteFrames(stream, folder);
  const ScenarioCamera& camera = stream.scenario().camera;
  fmt::print("{} frames of {}x{} {} with {} robots: {}\n", truth.size(), camera.render.camera.width,
             camera.render.camera.height, PixelFormatName(camera.render.format), stream.scenario().swarm.robots,
             folder.string());
  PrintPhases(stream.scenario(), truth);
}

}  // namespace chequer
