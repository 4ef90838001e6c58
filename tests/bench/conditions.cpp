// How boards fare in hard conditions, a line each: what is read, how exact, how honest its covariance and at what cost.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "simulate/random.h"
#include "support/pose_errors.h"
#include "support/stress_frames.h"

namespace chequer {
namespace {

/// A case of the simulator's, and what is changed in it: "jpeg=75,shadow=0.6:4,side=240".
struct Line {
  std::string text, tag;
  double blur_px = 0, side_px = 0, ink = -1, motion_px = 0, margin_cells = 0, shadow_takes = 0, shadow_px = 1;
};

Line Parse(const std::string& text) {
  Line line;
  line.text = text;
  std::stringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    const std::string name = part.substr(0, part.find('=')), value = part.substr(part.find('=') + 1);
    if (name == "blur") line.blur_px = std::stod(value);
    else if (name == "side") line.side_px = std::stod(value);
    else if (name == "ink") line.ink = std::stod(value);
    else if (name == "motion") line.motion_px = std::stod(value);
    else if (name == "margin") line.margin_cells = std::stod(value);
    else if (name == "shadow") line.shadow_takes = std::stod(value), line.shadow_px = std::stod(value.substr(value.find(':') + 1));
    else line.tag = part;
  }
  if (line.tag.empty()) line.tag = "side_px=48";
  return line;
}

StressCase CaseFor(const Line& line, const MarkerCode& code, std::uint64_t seed) {
  StressCase stress = test::CaseOf(line.tag, code, seed);
  SceneMarker& marker = stress.scene.markers[0];
  const CameraModel& camera = stress.options.camera;
  Random random(7000 + seed);
  if (line.blur_px > 0) stress.options.blur_sigma_px = line.blur_px;
  if (line.ink >= 0) marker.ink_spread_cells = line.ink;
  if (line.margin_cells > 0) marker.margin_cells = line.margin_cells;
  Eigen::Vector3d& at = marker.camera_from_marker.translation;
  if (line.side_px > 0) at = Eigen::Vector3d(0.1 * at.x(), 0.1 * at.y(), camera.fx * marker.side_m / line.side_px);
  if (line.motion_px > 0) {
    stress.options.motion_px = line.motion_px;
    stress.options.motion_angle_rad = random.Uniform(0, 2 * std::numbers::pi);
  }
  if (line.shadow_takes > 0) {
    const double direction = random.Uniform(0, 2 * std::numbers::pi), side_px = camera.fx * marker.side_m / at.z();
    const Eigen::Vector2d through = camera.Project(at) + random.Uniform(-0.45, 0.45) * side_px *
                                                             Eigen::Vector2d(std::cos(direction), std::sin(direction));
    stress.options.shadow = {.takes = line.shadow_takes, .direction_rad = direction, .through_x = through.x(),
                             .through_y = through.y(), .width_px = line.shadow_px};
  }
  return stress;
}

void Run(const Line& line, int seeds, std::uint64_t first, bool bayer, bool each) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  test::PoseErrors errors;
  std::vector<double> ms, units, mm, degrees, nees;
  std::vector<std::string> claimed;
  double square_mm = 0, claimed_mm = 0;
  int read = 0, wrong = 0, found = 0;
  for (std::uint64_t seed = first; seed < first + static_cast<std::uint64_t>(seeds); ++seed) {
    StressCase stress = CaseFor(line, code, seed);
    if (bayer) stress.options.format = PixelFormat::kBayerRg8;
    const SceneMarker& marker = stress.scene.markers[0];
    DetectorOptions options;
    options.families = {{.code = code, .side_m = marker.side_m, .roster = {}}};
    options.camera = stress.options.camera;
    Detector detector(options);
    const Image image = Render(stress.scene, stress.options, seed);
    std::vector<MarkerPose> markers;
    double least = 1e9;
    for (int i = 0; i < 2; ++i) {
      const auto start = std::chrono::steady_clock::now();
      detector.Detect(image.view(), markers);
      least = std::min(least, std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
    ms.push_back(least);
    units.push_back(static_cast<double>(detector.stats().work));
    for (const MarkerPose& pose : markers) {
      ++found;
      if (pose.id) ++(*pose.id == marker.board.id ? read : wrong);
      test::PoseErrors one;
      errors.Add(marker.camera_from_marker, pose);
      one.Add(marker.camera_from_marker, pose);
      nees.push_back((one.position() + one.orientation()) / 2);
      const double off = (pose.camera_from_marker.translation - marker.camera_from_marker.translation).norm() * 1e3;
      if (each)
        fmt::print("  seed {} off {:.3f} mm claimed {:.3f} sq {:.2f} {:.2f} corners {} rms {:.3f} ms {:.2f} id {} overlap {:.4f} {:.4f}\n", seed, off, std::sqrt(pose.covariance.topLeftCorner<3, 3>().trace()) * 1e3, one.position(), one.orientation(), pose.corners_used, pose.reprojection_rms_px, least, pose.id.has_value(), pose.luminance_overlap, pose.saturation_overlap);
      square_mm += off * off;
      mm.push_back(off);
      claimed_mm += std::sqrt(pose.covariance.topLeftCorner<3, 3>().trace()) * 1e3;
    }
  }
  const auto at = [](std::vector<double>& values, double share) {
    if (values.empty()) return 0.0;
    std::sort(values.begin(), values.end());
    return values[std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())))];
  };
  fmt::print("{:<42} {:4d} {:5.3f} {:5.3f} {:3d}  {:7.3f} {:7.3f} {:7.3f}  {:6.2f} {:6.2f} {:6.2f}  {:6.2f} {:6.2f} {:7.0f} {:7.0f}\n", line.text, seeds,
             double(found) / seeds, double(read) / seeds, wrong, std::sqrt(square_mm / std::max(found, 1)), at(mm, 0.5),
             claimed_mm / std::max(found, 1), errors.position(), errors.orientation(), at(nees, 0.5), at(ms, 0.5), at(ms, 0.99), at(units, 0.5), at(units, 0.99));
  std::fflush(stdout);
}

}  // namespace
}  // namespace chequer

int main(int argc, char** argv) {
  CLI::App app("How boards fare in hard conditions of the simulator, a line each.");
  std::vector<std::string> lines;
  int seeds = 40;
  std::uint64_t first = 1;
  bool bayer = false, each = false;
  app.add_option("condition", lines, "TAG of a stress case, with blur=PX side=PX ink=CELLS motion=PX margin=CELLS shadow=SHARE:PX, comma-separated")->required();
  app.add_option("--seeds", seeds, "Boards a line")->capture_default_str();
  app.add_option("--first", first, "First seed")->capture_default_str();
  app.add_flag("--bayer", bayer, "Raw Bayer frames instead of colour");
  app.add_flag("--each", each, "A line for each board, too");
  CLI11_PARSE(app, argc, argv);
  fmt::print("{:<42} {:>4} {:>5} {:>5} {:>3}  {:>7} {:>7} {:>7}  {:>6} {:>6} {:>6}  {:>6} {:>6} {:>7} {:>7}\n", "condition", "n", "found", "read", "bad",
             "rms mm", "median", "claimed", "sq/pos", "sq/rot", "median", "ms", "99 %", "units", "99 %");
  try {
    for (const std::string& line : lines) chequer::Run(chequer::Parse(line), seeds, first, bayer, each);
  } catch (const std::exception& error) {
    fmt::print(stderr, "conditions: {}\n", error.what());
    return 1;
  }
}
