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

/// "curve=gamma:1.4,gain=0.03,register=0.1,print=office,blur=0.6,camera=north.toml,tolerance=0.1,bend=0.5" (radius, m).
struct Condition {
  std::string text;
  RenderOptions render;
  PrintQuality print;
  std::string ink = "laser";
  double gain_cells = 0, bend_per_m = 0;
  PrintTolerance tolerance;
  std::optional<ToneCurve> tone;
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
    else if (name == "blur")
      condition.render.blur_sigma_px = std::stod(value);
    else if (name == "print")
      condition.print = NamedPrint(value).value().quality, condition.ink = NamedPrint(value).value().ink;
    else if (name == "tolerance")
      condition.tolerance = value == "office" ? kOfficePrints : PrintTolerance{0, std::stod(value) * 1e-3};
    else if (name == "camera")
      condition.tone = LoadCamera(value).tone_curve;
    else if (name == "gamma")
      condition.tone = ToneCurve::Gamma(std::stod(value));
    else if (!part.empty() && part != "ideal")
      throw CLI::ValidationError("condition", "'" + part + "' is not known");
  }
  if (condition.bend_per_m > 0) condition.print.bend_radius_m = 0;  // instead of the kind's
  return condition;
}

std::vector<SceneMarker> Boards(const Condition& condition, const MarkerCode& code, std::uint64_t seed) {
  Random random(900 + seed);
  std::vector<SceneMarker> markers;
  for (int i = 0; i < 4; ++i) {
    SceneMarker marker;
    const double tilt = random.Uniform(0, 40) * std::numbers::pi / 180, axis = random.Uniform(0, 2 * std::numbers::pi);
    const double z = random.Uniform(1.15, 1.25), x = (i % 2 == 0 ? -1 : 1) * random.Uniform(0.12, 0.2);
    const double y = (i / 2 == 0 ? -1 : 1) * random.Uniform(0.1, 0.17);
    marker.camera_from_marker = FacingPose({x, y, z}, random.Uniform(0, 2 * std::numbers::pi), tilt, axis);
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
  options.print_tolerance = condition.tolerance;
  Detector detector(options);
  const Renderer renderer(condition.render, Background{});
  int read = 0, wrong = 0, found = 0;
  double square_depth = 0, rms = 0, misfit = 0;
  std::uint64_t work = 0;
  std::vector<double> turns, squares;
  test::PoseErrors errors;
  for (std::uint64_t seed = first; seed < first + static_cast<std::uint64_t>(frames); ++seed) {
    const std::vector<SceneMarker> truth = Boards(condition, code, seed);
    const Image image = renderer.Render(truth, seed);
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
      test::PoseErrors one;
      one.Add(at, pose);
      errors.Add(at, pose);
      squares.push_back((one.position() + one.orientation()) / 2);
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
  fmt::print("{:<46} {:5.3f} {:5.3f} {:3d}  {:7.3f} {:7.3f}  {:7.2f} {:7.2f} {:7.2f}  {:7.1f}  {:6.4f} {:6.2f}\n",
             condition.text, found / (4.0 * frames), read / (4.0 * frames), wrong,
             1e3 * std::sqrt(square_depth / std::max(found, 1)), At(turns, 0.5), errors.position(),
             errors.orientation(), At(squares, 0.5), static_cast<double>(work) / (4.0 * frames),
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
                 "curve=bt709 gain=CELLS register=MM print=KIND blur=PX tolerance=office|MM "
                 "camera=FILE gamma=G, comma-separated")
      ->required();
  app.add_option("--frames", frames, "Of a condition")->capture_default_str();
  app.add_option("--first", first, "First seed")->capture_default_str();
  app.add_flag("--each", each, "A line for each board, too");
  CLI11_PARSE(app, argc, argv);
  fmt::print("{:<46} {:>5} {:>5} {:>3}  {:>7} {:>7}  {:>7} {:>7} {:>7}  {:>7}  {:>6} {:>6}\n", "condition", "found",
             "read", "bad", "depth", "turn", "sq/pos", "sq/rot", "median", "work", "rms px", "misfit");
  for (const std::string& condition : conditions) chequer::Run(chequer::Parse(condition), frames, first, each);
}
