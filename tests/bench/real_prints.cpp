// What prints and cameras that are not ideal cost: a line for each condition, with how exact and how honest poses are.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "chequer/camera_file.h"
#include "chequer/detector.h"
#include "simulate/print_quality.h"
#include "simulate/random.h"
#include "simulate/render.h"
#include "support/pose_errors.h"

namespace chequer {
namespace {

/// χ² of six numbers that one pose in a thousand exceeds.
constexpr double kGate = 22.46;

/// "curve=gamma:1.4,gain=0.03,register=0.1,print=office,blur=0.6,camera=north.toml,tolerance=0.1,bend=0.5" (radius, m).
struct Condition {
  std::string text;
  RenderOptions render;
  PrintQuality print;
  int boards = 4;
  double moving = 0;  ///< share of the frames with motion
  std::string ink = "laser";
  double gain_cells = 0, bend_per_m = 0;
  PrintTolerance tolerance;
  std::optional<ToneCurve> tone;
  std::optional<CameraModel> lens;  ///< as calibrated; else the true one
};

Condition Parse(const std::string& text) {
  Condition condition;
  condition.text = text;
  condition.render.camera = {.width = 640, .height = 480, .fx = 990, .fy = 990, .cx = 319.5, .cy = 239.5};
  std::stringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    const std::string name = part.substr(0, part.find('=')), value = part.substr(part.find('=') + 1);
    if (name == "curve")
      condition.render.processing.curve = ParseCameraCurve(value).value();
    else if (name == "gain")
      condition.gain_cells = std::stod(value);
    else if (name == "register")
      condition.print.register_m = std::stod(value) * 1e-3;
    else if (name == "bend")
      condition.bend_per_m = 1 / std::stod(value);
    else if (name == "gloss")
      condition.print.gloss = std::stod(value);
    else if (name == "stretch")
      condition.print.scale.x() = std::stod(value);
    else if (name == "webcam") {
      const CameraPreset preset = FindCameraPreset(value).value();
      condition.render.processing = preset.processing;
      condition.render.format = preset.format;
      condition.render.jpeg_quality = preset.jpeg_quality;
    } else if (name == "jpeg")
      condition.render.jpeg_quality = std::stoi(value);
    else if (name == "aberration")
      condition.render.processing.chromatic_aberration_px = std::stod(value);
    else if (name == "sharpening")
      condition.render.processing.sharpening = std::stod(value);
    else if (name == "denoising")
      condition.render.processing.denoising_levels = std::stod(value);
    else if (name == "saturation")
      condition.render.processing.saturation = std::stod(value);
    else if (name == "upscaling")
      condition.render.processing.upscaling = std::stod(value);
    else if (name == "exposure")
      condition.render.sensor.exposure = std::stod(value);
    else if (name == "full-well")
      condition.render.sensor.full_well_electrons = std::stod(value);
    else if (name == "motion")
      condition.moving = 0.4, condition.render.motion_px = std::stod(value);
    else if (name == "boards") {
      condition.boards = std::stoi(value);
      condition.render.camera = {.width = 1280, .height = 720, .fx = 990, .fy = 990, .cx = 639.5, .cy = 359.5};
    } else if (name == "blur")
      condition.render.blur_sigma_px = std::stod(value);
    else if (name == "print")
      condition.print = NamedPrint(value).value().quality, condition.ink = NamedPrint(value).value().ink;
    else if (name == "tolerance")
      condition.tolerance = value == "office" ? kOfficePrints : PrintTolerance{0, std::stod(value) * 1e-3};
    else if (name == "camera")
      condition.tone = LoadCamera(value).tone_curve;
    else if (name == "lens")
      condition.lens = LoadCamera(value);
    else if (name == "gamma")
      condition.tone = ToneCurve::Gamma(std::stod(value));
    else if (!part.empty() && part != "ideal")
      throw CLI::ValidationError("condition", "'" + part + "' is not known");
  }
  if (condition.bend_per_m > 0) condition.print.bend_radius_m = 0;  // instead of the kind's
  return condition;
}

/// Of board i of four at 1.2 m, or of any other number at 0.8 to 2 m, in four columns.
Eigen::Vector3d Place(const Condition& condition, int i, Random& random) {
  if (condition.boards == 4) {
    const double z = random.Uniform(1.15, 1.25), x = (i % 2 == 0 ? -1 : 1) * random.Uniform(0.12, 0.2);
    return {x, (i / 2 == 0 ? -1 : 1) * random.Uniform(0.1, 0.17), z};
  }
  const CameraModel& camera = condition.render.camera;
  const int rows = (condition.boards + 3) / 4;
  const double z = random.Uniform(0.8, 2), column = (i % 4 + 0.5) / 4, row = (i / 4 + 0.5) / rows;
  const double u = column * camera.width + random.Uniform(-60, 60), v = row * camera.height + random.Uniform(-30, 30);
  return {(u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z};
}

std::vector<SceneMarker> Boards(const Condition& condition, const MarkerCode& code, std::uint64_t seed) {
  Random random(900 + seed);
  std::vector<SceneMarker> markers;
  for (int i = 0; i < condition.boards; ++i) {
    SceneMarker marker;
    const double tilt = random.Uniform(0, 40) * std::numbers::pi / 180, axis = random.Uniform(0, 2 * std::numbers::pi);
    const Eigen::Vector3d at = Place(condition, i, random);
    marker.camera_from_marker = FacingPose(at, random.Uniform(0, 2 * std::numbers::pi), tilt, axis);
    marker.board = MakeBoard(code, random.Bits() % (code.max_id() + 1));
    marker.side_m = 0.08;
    marker.inks = NamedInks(condition.ink).value();
    marker.margin_cells = 1;
    marker.ink_spread_cells = condition.gain_cells;
    if (condition.bend_per_m > 0) {
      marker.bend_per_m = (random.Bits() % 2 == 0 ? 1 : -1) * condition.bend_per_m;
      marker.bend_angle_rad = random.Uniform(0, std::numbers::pi);
    }
    Print(condition.print, random.Bits(), marker);
    markers.push_back(marker);
  }
  return markers;
}

double At(std::vector<double>& values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

void Run(const Condition& condition, int frames, std::uint64_t first, bool each) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  DetectorOptions options;
  options.families = {{.code = code, .side_m = 0.08, .roster = {}}};
  options.camera = condition.render.camera;
  options.camera->tone_curve = condition.tone;
  if (condition.lens) options.camera = condition.lens;
  options.print_tolerance = condition.tolerance;
  Detector detector(options);
  const double all = static_cast<double>(condition.boards) * frames;
  int read = 0, wrong = 0, found = 0, outside = 0;
  double square_depth = 0, rms = 0, misfit = 0;
  std::uint64_t work = 0;
  std::vector<double> turns, squares;
  test::PoseErrors errors;
  for (std::uint64_t seed = first; seed < first + static_cast<std::uint64_t>(frames); ++seed) {
    const std::vector<SceneMarker> truth = Boards(condition, code, seed);
    RenderOptions render = condition.render;
    if (condition.moving > 0) {
      Random random(DeriveSeed(seed, 77));
      render.motion_px = random.Uniform() < condition.moving ? random.Uniform(0, render.motion_px) : 0;
      render.motion_angle_rad = random.Uniform(0, 2 * std::numbers::pi);
    }
    const Image image = Renderer(render, Background{}).Render(truth, seed);
    const std::vector<MarkerPose> poses = detector.Detect(image.view());
    work += detector.stats().work;
    for (const MarkerPose& pose : poses) {
      const auto nearest = std::min_element(truth.begin(), truth.end(), [&](const auto& a, const auto& b) {
        const auto off = [&](const SceneMarker& marker) {
          return (CenterPx(marker, condition.render.camera) - pose.center_px).norm();
        };
        return off(a) < off(b);
      });
      const RigidTransform& at = nearest->camera_from_marker;
      ++found;
      if (pose.id) ++(*pose.id == nearest->board.id ? read : wrong);
      if (pose.id && *pose.id != nearest->board.id)
        fmt::print("  wrong: seed {}, id {} for {}, {} corrected, overlaps {:.3f} {:.3f}, {} corners off by {:.3f} px\n", seed,
                   *pose.id, nearest->board.id, pose.bits_corrected, pose.luminance_overlap, pose.saturation_overlap,
                   pose.corners_used, pose.reprojection_rms_px);
      test::PoseErrors one;
      one.Add(at, pose);
      errors.Add(at, pose);
      squares.push_back((one.position() + one.orientation()) / 2);
      outside += 6 * squares.back() > kGate;
      const Eigen::Vector3d off = pose.camera_from_marker.translation - at.translation;
      square_depth += off.z() * off.z();
      rms += pose.reprojection_rms_px, misfit += pose.misfit;
      const Eigen::Quaterniond turn = at.rotation * pose.camera_from_marker.rotation.conjugate();
      turns.push_back(VectorFromRotation(turn.normalized()).norm() * 180 / std::numbers::pi);
      if (each)
        fmt::print("  {} depth {:+.3f} mm turn {:.3f} sq {:.2f} {:.2f} rms {:.3f} px misfit {:.2f}\n", seed,
                   off.z() * 1e3, turns.back(), one.position(), one.orientation(), pose.reprojection_rms_px,
                   pose.misfit);
    }
  }
  fmt::print("{:<46} {:5.3f} {:5.3f} {:3d}  {:7.3f} {:7.3f}  {:7.2f} {:7.2f} {:7.2f} {:5.1f}  {:7.1f}  {:6.4f} {:6.2f}\n",
             condition.text, found / all, read / all, wrong,
             1e3 * std::sqrt(square_depth / std::max(found, 1)), At(turns, 0.5), errors.position(),
             errors.orientation(), At(squares, 0.5), 100.0 * outside / std::max(found, 1), static_cast<double>(work) / all,
             rms / std::max(found, 1), misfit / std::max(found, 1));
  std::fflush(stdout);
}

}  // namespace
}  // namespace chequer

int main(int argc, char** argv) {
  CLI::App app("Four 80 mm boards at 1.2 m (cells of 11 px), printed and seen in conditions that are not ideal.");
  std::vector<std::string> conditions;
  int frames = 40;
  std::uint64_t first = 1;
  bool each = false;
  app.add_option("condition", conditions,
                 "curve=bt709 gain=CELLS register=MM print=KIND stretch=WIDTH gloss=G bend=M blur=PX "
                 "tolerance=office|MM camera=FILE (its curve) lens=FILE (all of it) gamma=G webcam=NAME jpeg=Q aberration=PX sharpening=S denoising=L "
                 "saturation=S upscaling=F exposure=E full-well=N motion=PX (two frames in five) boards=12 (1280 x 720, "
                 "0.8 to 2 m), comma-separated")
      ->required();
  app.add_option("--frames", frames, "Of a condition")->capture_default_str();
  app.add_option("--first", first, "First seed")->capture_default_str();
  app.add_flag("--each", each, "A line for each board, too");
  CLI11_PARSE(app, argc, argv);
  fmt::print("{:<46} {:>5} {:>5} {:>3}  {:>7} {:>7}  {:>7} {:>7} {:>7} {:>5}  {:>7}  {:>6} {:>6}\n", "condition", "found",
             "read", "bad", "depth", "turn", "sq/pos", "sq/rot", "median", "out%", "work", "rms px", "misfit");
  for (const std::string& condition : conditions) chequer::Run(chequer::Parse(condition), frames, first, each);
}
