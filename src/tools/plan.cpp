#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/file.h"
#include "core/length.h"
#include "marker/variants.h"
#include "tools/calibrate.h"
#include "tools/commands.h"
#include "tools/length_option.h"
#include "tools/marker_options.h"
#include "tools/number_check.h"
#include "tools/plan_estimate.h"
#include "tools/plan_picture.h"
#include "tools/render_request.h"
#include "tools/setup_option.h"

namespace chequer {
namespace {

/// Ends the program where the markers will not be read, for scripts.
constexpr int kExitNotRead = 3;
/// Motion blur that still leaves poses as exact as they say, cells.
constexpr double kHarmlessBlurCells = 0.5;

struct PlanRequest {
  std::string config;
  RenderRequest camera;  ///< of it the camera alone
  MarkerOptions markers;
  double distance_m = 0;
  double tilt_deg = 5;
  double speed_m_s = 0.5;
  std::string out;
};

PlanScene PlanSceneOf(PlanRequest& request) {
  const auto setup = LoadSetup(request.config);
  request.camera.setup = setup;
  const MarkerFamily family = ChooseMarkerFamilies(request.markers, setup, true).front();
  PlanScene scene;
  scene.view.camera = PlanCamera(request.camera);
  scene.code = family.code;
  scene.side_m = family.side_m;
  scene.distance_m = request.distance_m;
  scene.max_tilt_rad = request.tilt_deg * M_PI / 180;
  return scene;
}

std::string VerdictLine(const PlanEstimate& e) {
  if (!e.fits) return "not read: the marker is larger than what the image shows";
  const std::string cells = fmt::format(
      "cells are {:.1f} px wide, {:.1f} times the {:g} px that are safe; {} of {} "
      "simulated markers are read",
      e.cell_px, e.cell_px / kSafeCellPx, kSafeCellPx, e.read, e.trials);
  switch (e.Verdict()) {
    case PlanVerdict::kRead: return "read: " + cells;
    case PlanVerdict::kDoubtful: return "doubtful: " + cells;
    case PlanVerdict::kNotRead: return "not read: " + cells;
  }
  return cells;
}

std::string ErrorLine(const Eigen::Vector3d& position_m, const Eigen::Vector3d& angle_rad) {
  const Eigen::Vector3d mm = 1000 * position_m, deg = angle_rad * 180 / M_PI;
  return fmt::format("x {:.3f} mm, y {:.3f} mm, z {:.2f} mm; heading {:.3f} deg, tilt {:.2f} deg", mm.x(), mm.y(),
                     mm.z(), deg.z(), std::hypot(deg.x(), deg.y()));
}

std::vector<std::string> Report(const PlanRequest& request, const PlanScene& scene, const PlanEstimate& e) {
  const CameraModel& camera = scene.view.camera;
  const auto whole = [&](double length_m) { return std::max(length_m - scene.side_m, 0.0); };
  std::vector<std::string> lines{
      fmt::format("{} {} of {}, {} away, by {} x {} pixels with a focal length of {:.0f} px",
                  ToString(scene.code.size()), VariantName(scene.code.variant()), LengthText(scene.side_m),
                  LengthText(scene.distance_m), camera.width, camera.height, camera.fx),
      "verdict   " + VerdictLine(e)};
  if (e.read > 0) {
    lines.push_back("error     " + ErrorLine(e.error_m, e.error_rad) + " (simulated, RMS)");
    if (e.mirrored > 0)
      lines.push_back(
          fmt::format("          {} of {} took the mirrored tilt, and say so (ambiguous_pose)", e.mirrored, e.read));
    lines.push_back("at best   " + ErrorLine(e.bound_m, e.bound_rad) + " (Cramer-Rao bound)");
  }
  lines.push_back(fmt::format("enough    a side of {:.0f} mm at this distance, or {:.2f} m away with this side",
                              std::ceil(1000 * e.smallest_side_m - 1e-6), e.farthest_m));
  lines.push_back(fmt::format("covers    {:.2f} x {:.2f} m; markers are whole in {:.2f} x {:.2f} m", e.seen_m.x(),
                              e.seen_m.y(), whole(e.seen_m.x()), whole(e.seen_m.y())));
  const double cell_m = scene.side_m / std::max(scene.code.size().rows, scene.code.size().cols);
  if (request.speed_m_s > 0)
    lines.push_back(fmt::format("exposure  at most {:.1f} ms for {:g} m/s: half a cell of motion blur",
                                1000 * kHarmlessBlurCells * cell_m / request.speed_m_s, request.speed_m_s));
  return lines;
}

void RunPlan(PlanRequest& request) {
  if (!request.out.empty()) CheckPngName("--out", request.out);
  const PlanScene scene = PlanSceneOf(request);
  const PlanEstimate estimate = EstimatePlan(scene);
  const std::vector<std::string> lines = Report(request, scene, estimate);
  for (const std::string& line : lines) std::printf("%s\n", line.c_str());
  if (!request.out.empty()) WriteFileAtomically(request.out, DrawPlan(scene, estimate, lines));
  if (std::fflush(stdout) != 0) throw std::runtime_error("standard output could not be written to the end");
  if (estimate.Verdict() == PlanVerdict::kNotRead) throw CLI::RuntimeError(kExitNotRead);
}

}  // namespace

void AddPlanCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("plan", "Says whether a camera will read markers, and how exactly");
  // Shared, as the callback outlives this function and std::function copies what it holds.
  const auto request = std::make_shared<PlanRequest>();
  AddSetupOption(*command, request->config, "camera file and markers");
  AddMarkerOptions(*command, request->markers);
  AddRenderCameraOptions(*command, request->camera);
  AddLengthOption(*command, "--distance", request->distance_m, "Of the markers from the camera")->required();
  command->add_option("--tilt", request->tilt_deg, "Largest tilt of the markers, degrees, to 68")
      ->check(IsWithin(0, 68))
      ->type_name("DEG")
      ->capture_default_str();
  command->add_option("--speed", request->speed_m_s, "Of the robots, m/s: how long may the exposure be?")
      ->check(IsWithin(0, 1000))
      ->capture_default_str();
  command->add_option("--out", request->out, "Also a picture of it, .png")->type_name("FILE");
  command->footer(
      "Renders markers at random places, with the noise of a good sensor and a lens in focus, and detects them. A\n"
      "sharper lens, less light or motion change the errors; `chequer render` has options for all of these. The bound\n"
      "is what no detector can be better than. A camera of which nothing is said has 1920 x 1080 pixels; one without "
      "a\n"
      "focal length has that of a view 67 degrees wide.\n\n"
      "Exit status: 0 where they are read, 3 where they are not.\n\n"
      "Will markers of 40 mm be read from 3 m with a 12 mm lens on pixels of 3.45 um?\n"
      "  chequer plan --side 40mm --distance 3m --lens 12mm --pixel 3.45um --out plan.png\n"
      "How small may they be for a webcam (60 degrees wide) that hangs at 2 m?\n"
      "  chequer plan --side 60mm --distance 2m --size 1280x720 --focal 1100");
  command->callback([request] { RunPlan(*request); });
}

}  // namespace chequer
