// Ids of small boards in the pixel formats of webcams: how many are read, how many are wrong, a line for each format and
// side. The boards lie at random places, headings, tilts and gains before random backgrounds.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "chequer/detect_trace.h"
#include "chequer/detector.h"
#include "simulate/print_quality.h"
#include "simulate/processing.h"
#include "simulate/random.h"
#include "simulate/render.h"
#include "simulate/truth.h"

namespace chequer::bench {
namespace {

constexpr double kFocalPx = 600;
constexpr double kSideM = 0.08;

/// What a camera delivers.
struct Delivery {
  std::string name;
  PixelFormat format = PixelFormat::kBgr8;
  std::optional<int> jpeg_quality{};
  YuvRange range = YuvRange::kFull;
  ProcessingOptions processing{};
};

/// A webcam's preset.
Delivery Webcam(const char* name) {
  const CameraPreset preset = FindCameraPreset(name).value();
  return {name, preset.format, preset.jpeg_quality, YuvRange::kFull, preset.processing};
}

std::vector<Delivery> Deliveries() {
  return {{"png", PixelFormat::kBgr8},
          {"yuyv", PixelFormat::kYuyv},
          {"nv12", PixelFormat::kNv12},
          {"yuyv-limited", PixelFormat::kYuyv, {}, YuvRange::kLimited},
          {"nv12-limited", PixelFormat::kNv12, {}, YuvRange::kLimited},
          {"mjpeg-90", PixelFormat::kYuv422p, 90},
          {"mjpeg-75", PixelFormat::kYuv422p, 75},
          {"mjpeg-60", PixelFormat::kYuv422p, 60},
          {"mjpeg-60-420", PixelFormat::kYuv420p, 60},
          Webcam("webcam-yuyv"),
          Webcam("webcam-nv12"),
          Webcam("webcam-mjpeg")};
}

/// What the scenes vary in.
struct Variation {
  double least_tilt_deg = 0, most_tilt_deg = 25;
  double gain = 0;  ///< exposure and each channel's white balance are off by factors up to e^±gain
  double full_well = 10000;
  bool full_colour = true;  ///< the sensor has three colours a pixel; else a mosaic
  double blur_px = 0.6;
  double exposure = 1;
  double moving = 0, motion_px = 6;  ///< share of frames with motion, and the longest
  std::string print;                 ///< kind, or ideal ones of two inks
};

struct Count {
  int boards = 0, found = 0, read = 0, wrong = 0, corrected = 0, wrong_corrected = 0, wrong_warned = 0, warned = 0;
};

Scene SceneOf(double side_px, const Variation& variation, const MarkerCode& code, RenderOptions& options, Random& random) {
  constexpr BackgroundKind kKinds[] = {BackgroundKind::kPlain, BackgroundKind::kNoise, BackgroundKind::kTiles,
                                       BackgroundKind::kWood, BackgroundKind::kText};
  constexpr const char* kInks[] = {"laser", "inkjet"};
  Scene scene;
  scene.background.kind = kKinds[random.Below(5)];
  scene.background.seed = random.Bits();
  const double pitch = 1.7 * side_px, depth = kSideM * kFocalPx / side_px;
  for (double y = pitch; y < options.camera.height - pitch; y += pitch)
    for (double x = pitch; x < options.camera.width - pitch; x += pitch) {
      SceneMarker marker;
      marker.board = MakeBoard(code, static_cast<std::uint64_t>(random.Below(static_cast<int>(code.max_id() + 1))));
      marker.side_m = kSideM;
      marker.inks = *NamedInks(kInks[random.Below(2)]);
      marker.margin_cells = random.Below(2);
      const double u = x + random.Uniform(-3, 3) - options.camera.cx, v = y + random.Uniform(-3, 3) - options.camera.cy;
      marker.camera_from_marker =
          FacingPose({u / kFocalPx * depth, v / kFocalPx * depth, depth}, random.Uniform(0, 2 * std::numbers::pi),
                     random.Uniform(variation.least_tilt_deg, variation.most_tilt_deg) * std::numbers::pi / 180,
                     random.Uniform(0, 2 * std::numbers::pi));
      if (!variation.print.empty()) {
        const PrintKind kind = NamedPrint(variation.print).value();
        marker.inks = NamedInks(kind.ink).value();
        Print(kind.quality, random.Bits(), marker);
      }
      scene.markers.push_back(std::move(marker));
    }
  options.sensor.exposure = variation.exposure * std::exp(random.Uniform(-variation.gain, variation.gain));
  for (double& factor : options.sensor.white_balance) factor = std::exp(random.Uniform(-variation.gain, variation.gain));
  if (variation.moving > 0) {
    options.motion_px = random.Uniform() < variation.moving ? random.Uniform(0, variation.motion_px) : 0;
    options.motion_angle_rad = random.Uniform(0, 2 * std::numbers::pi);
  }
  return scene;
}

/// @param name of the format, to print wrong ids with.
void Add(const std::string& name, int frame, const std::vector<TrueMarker>& truth,
         const std::vector<MarkerPose>& markers, double side_px, Count& count) {
  count.boards += static_cast<int>(truth.size());
  for (const MarkerPose& marker : markers) {
    const auto near = std::min_element(truth.begin(), truth.end(), [&](const TrueMarker& a, const TrueMarker& b) {
      return (a.center_px - marker.center_px).norm() < (b.center_px - marker.center_px).norm();
    });
    const bool there = near != truth.end() && (near->center_px - marker.center_px).norm() < side_px / 4;
    count.found += there;
    if (!marker.id) continue;
    const bool right = there && near->id == *marker.id, warned = marker.Has(Warning::kPoorWhiteBalance);
    ++(right ? count.read : count.wrong);
    if (!right)
      fmt::print("  wrong: {} frame {} at {:.1f} {:.1f}, {:.1f} px off, id {} for {}, {} corrected, overlaps {:.3f} {:.3f}, "
                 "{} corners off by {:.3f} px\n",
                 name, frame, marker.center_px.x(), marker.center_px.y(),
                 near == truth.end() ? -1.0 : (near->center_px - marker.center_px).norm(), *marker.id,
                 near == truth.end() ? 0 : near->id, marker.bits_corrected, marker.luminance_overlap,
                 marker.saturation_overlap, marker.corners_used, marker.reprojection_rms_px);
    count.corrected += marker.bits_corrected > 0;
    count.warned += warned;
    count.wrong_corrected += !right && marker.bits_corrected > 0;
    count.wrong_warned += !right && warned;
  }
}

/// Prints what became of boards that no marker was found for, and adds to the counts of their refusals.
void TellMissed(int frame, const std::vector<TrueMarker>& truth, const std::vector<MarkerPose>& markers, double side_px,
                const DetectTrace& trace, std::map<std::string, int>& refusals) {
  for (const TrueMarker& board : truth) {
    const auto lies_there = [&](const Eigen::Vector2d& at) { return (at - board.center_px).norm() < side_px / 4; };
    if (std::any_of(markers.begin(), markers.end(), [&](const MarkerPose& m) { return lies_there(m.center_px); }))
      continue;
    const auto corners = std::count_if(trace.corners.begin(), trace.corners.end(), [&](const auto& corner) {
      return (corner.position_px.template cast<double>() - board.center_px).norm() < side_px / 2;
    });
    Refusal farthest = Refusal::kNone;
    std::size_t linked = 0;
    for (const TraceCandidate& candidate : trace.candidates)
      if (lies_there(candidate.center_px) || std::any_of(candidate.corners.begin(), candidate.corners.end(), [&](int c) {
            return lies_there(trace.corners[static_cast<std::size_t>(c)].position_px.template cast<double>());
          }))
        farthest = std::max(farthest, candidate.refusal), linked = std::max(linked, candidate.corners.size());
    ++refusals[std::string(RefusalName(farthest))];
    fmt::print("  missed: frame {} at {:.1f} {:.1f}, {} corners, {} linked: {}\n", frame, board.center_px.x(),
               board.center_px.y(), corners, linked, RefusalName(farthest));
  }
}

/// Counts over frames until there are so many reads of each format, or so many frames.
void Run(double side_px, const std::vector<Delivery>& deliveries, const Variation& variation, int frames,
         std::uint64_t seed, bool missed) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  std::vector<Count> counts(deliveries.size());
  RenderOptions options;
  options.camera = {.width = 640, .height = 480, .fx = kFocalPx, .fy = kFocalPx, .cx = 319.5, .cy = 239.5};
  options.blur_sigma_px = variation.blur_px;
  options.sensor.kind = variation.full_colour ? SensorKind::kPerfect : SensorKind::kBayer;
  options.sensor.full_well_electrons = variation.full_well;
  DetectorOptions sought;
  sought.families = {{.code = code, .side_m = kSideM, .roster = {}}};
  sought.camera = options.camera;
  Detector detector(sought);
  std::vector<MarkerPose> markers;
  std::vector<std::uint64_t> work(deliveries.size());
  std::map<std::string, int> refusals;
  for (int frame = 0; frame < frames; ++frame) {
    Random random(DeriveSeed(seed, static_cast<std::uint64_t>(frame)));
    const Scene scene = SceneOf(side_px, variation, code, options, random);
    const LinearImage light = RenderLight(scene, options);
    const std::vector<TrueMarker> truth = TruthOf(scene.markers, options.camera);
    const std::uint64_t noise = random.Bits();
    for (std::size_t i = 0; i < deliveries.size(); ++i) {
      options.format = deliveries[i].format;
      options.jpeg_quality = deliveries[i].jpeg_quality;
      options.yuv_range = deliveries[i].range;
      options.processing = deliveries[i].processing;
      const Image image = Capture(light, options, noise);
      DetectTrace trace;
      detector.Detect(image.view(), markers, missed ? &trace : nullptr);
      if (missed) TellMissed(frame, truth, markers, side_px, trace, refusals);
      work[i] += detector.stats().work;
      Add(deliveries[i].name, frame, truth, markers, side_px, counts[i]);
    }
  }
  for (std::size_t i = 0; i < deliveries.size(); ++i) {
    const Count& c = counts[i];
    const double all = std::max(c.boards, 1);
    fmt::print("{:<14} {:5.1f} {:7d}  {:6.1f} {:6.1f}  {:5d} {:5d} {:5d}  {:9d} {:6d}  {:7.0f}\n", deliveries[i].name, side_px,
               c.boards, 100 * c.found / all, 100 * c.read / all, c.wrong, c.wrong_corrected, c.wrong_warned,
               c.corrected, c.warned, static_cast<double>(work[i]) / all);
  }
  for (const auto& [refusal, boards] : refusals) fmt::print("  {} missed: {}\n", boards, refusal);
  std::fflush(stdout);
}

}  // namespace
}  // namespace chequer::bench

int main(int argc, char** argv) {
  CLI::App app("Ids of small boards in the pixel formats of webcams.");
  std::vector<double> sides{24, 30};
  std::vector<std::string> names;
  chequer::bench::Variation variation;
  int frames = 20;
  std::uint64_t seed = 1;
  bool mosaic = false, missed = false;
  app.add_option("--side", sides, "Of the boards, pixels")->capture_default_str();
  app.add_option("--format", names, "Those to try [all]");
  app.add_option("--frames", frames, "For each side")->capture_default_str();
  app.add_option("--seed", seed)->capture_default_str();
  app.add_option("--least-tilt", variation.least_tilt_deg, "Degrees")->capture_default_str();
  app.add_option("--tilt", variation.most_tilt_deg, "At most, degrees")->capture_default_str();
  app.add_option("--gain", variation.gain, "Exposure and white balance are off by factors up to e^+-GAIN")->capture_default_str();
  app.add_option("--full-well", variation.full_well, "Electrons at full scale")->capture_default_str();
  app.add_option("--exposure", variation.exposure, "1: paper is at 85 % of full scale")->capture_default_str();
  app.add_option("--moving", variation.moving, "Share of the frames with motion, any way")->capture_default_str();
  app.add_option("--motion", variation.motion_px, "Of those, the longest, pixels")->capture_default_str();
  app.add_option("--print", variation.print, "Kind of the prints, such as inkjet-worn");
  app.add_option("--blur", variation.blur_px, "Of the lens, pixels")->capture_default_str();
  app.add_flag("--mosaic", mosaic, "A sensor with one colour a pixel");
  app.add_flag("--missed", missed, "What became of each board that was not found");
  CLI11_PARSE(app, argc, argv);
  variation.full_colour = !mosaic;
  std::vector<chequer::bench::Delivery> deliveries;
  for (const auto& delivery : chequer::bench::Deliveries())
    if (names.empty() || std::find(names.begin(), names.end(), delivery.name) != names.end()) deliveries.push_back(delivery);
  fmt::print("{:<14} {:>5} {:>7}  {:>6} {:>6}  {:>5} {:>5} {:>5}  {:>9} {:>6}  {:>7}\n", "format", "side", "boards",
             "found%", "read%", "wrong", "corr.", "warn.", "corrected", "warned", "work");
  for (const double side : sides) chequer::bench::Run(side, deliveries, variation, frames, seed, missed);
}
