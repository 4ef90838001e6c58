#include "simulate/stress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "simulate/random.h"

namespace chequer {
namespace {

constexpr double kSideM = 0.12;
constexpr double kFocalPx = 1000;

/// What a condition does to a frame, given how much.
using Change = std::function<void(StressCase&, double, Random&)>;

struct Condition {
  const char* name;
  double side_px;
  std::vector<double> amounts;
  Change change;
};

double RadiansOf(double degrees) { return degrees * M_PI / 180; }

SceneMarker& Marker(StressCase& stress) { return stress.scene.markers[0]; }

StressCase Plain(double side_px, double tilt_rad, const MarkerCode& code, Random& random) {
  StressCase stress;
  stress.options.camera = {.width = 640, .height = 480, .fx = kFocalPx, .fy = kFocalPx, .cx = 320, .cy = 240};
  stress.options.camera.kind = CameraModel::Kind::kBrownConrady;
  stress.options.camera.distortion = {-0.1, 0.02, 0, 0, 0};
  stress.options.blur_sigma_px = 0.7;
  SceneMarker marker;
  const double ids = std::min(static_cast<double>(code.max_id()) + 1, 0x1p53);
  marker.board = MakeBoard(code, static_cast<std::uint64_t>(random.Uniform() * ids));
  marker.side_m = kSideM;
  const double depth = kSideM * kFocalPx / side_px;
  // Room for the marker's half diagonal, in pixels, on all sides.
  const double rim = 0.75 * side_px + 2;
  const double x = random.Uniform(-1, 1) * std::max(0.0, 320 - rim),
               y = random.Uniform(-1, 1) * std::max(0.0, 240 - rim);
  const double heading = random.Uniform(0, 2 * M_PI), axis = random.Uniform(0, 2 * M_PI);
  marker.camera_from_marker =
      FacingPose({0.6 * x / kFocalPx * depth, 0.6 * y / kFocalPx * depth, depth}, heading, tilt_rad, axis);
  stress.scene.markers.push_back(std::move(marker));
  // Without boards and letters: they would make a second thing hard.
  constexpr BackgroundKind kKinds[] = {BackgroundKind::kPlain, BackgroundKind::kNoise, BackgroundKind::kTiles,
                                       BackgroundKind::kWood};
  stress.scene.background.kind = kKinds[random.Below(4)];
  stress.scene.background.seed = random.Bits();
  return stress;
}

void HideStrip(StressCase& stress, double part, Random& random) {
  Occluder strip{.from = {-0.1, -0.1}, .to = {1.1, part}};
  if (random.Below(2) == 0) strip = {.from = {1 - part, -0.1}, .to = {1.1, 1.1}};
  strip.patches = 8;
  strip.seed = random.Bits();
  Marker(stress).occluders.push_back(strip);
}

std::vector<Condition> Conditions() {
  const Change nothing = [](StressCase&, double, Random&) {};
  return {
      {"side_px", 0, {18, 21, 24, 27, 30, 36, 48, 96, 240, 320}, nothing},
      {"tilt_deg", 90, {30, 45, 55, 65, 70, 75, 80}, nothing},
      {"psf_px", 60, {1, 1.5, 2, 2.5, 3}, [](auto& s, double v, Random&) { s.options.blur_sigma_px = v; }},
      {"full_well",
       60,
       {3000, 1000, 300, 100},
       [](auto& s, double v, Random&) { s.options.sensor.full_well_electrons = v; }},
      {"motion_px",
       60,
       {2, 4, 6, 8, 12},
       [](auto& s, double v, Random& random) {
         s.options.motion_px = v;
         s.options.motion_angle_rad = random.Uniform(0, 2 * M_PI);
       }},
      {"exposure",
       60,
       {0.03, 0.06, 0.12, 0.25, 1.3, 1.6},
       [](auto& s, double v, Random&) { s.options.sensor.exposure = v; }},
      {"gradient",
       120,
       {0.5, 0.7, 0.9},
       [](auto& s, double v, Random& random) {
         Marker(s).gradient = v;
         Marker(s).gradient_angle_rad = random.Uniform(0, 2 * M_PI);
       }},
      {"haze", 60, {0.1, 0.25, 0.4}, [](auto& s, double v, Random&) { s.options.lighting.haze = v; }},
      {"wb_red", 60, {0.7, 0.8, 1.25, 1.4}, [](auto& s, double v, Random&) { s.options.sensor.white_balance[0] = v; }},
      {"jpeg", 60, {90, 75, 50, 30}, [](auto& s, double v, Random&) { s.options.jpeg_quality = static_cast<int>(v); }},
      {"occluded", 60, {0.1, 0.2, 0.34, 0.5}, HideStrip},
      {"ink_spread", 60, {0.05, 0.1, 0.2}, [](auto& s, double v, Random&) { Marker(s).ink_spread_cells = v; }},
  };
}

}  // namespace

std::vector<StressCase> StressCases(const MarkerCode& code, std::uint64_t seed) {
  Random random(seed);
  std::vector<StressCase> cases;
  for (const Condition& condition : Conditions())
    for (const double amount : condition.amounts) {
      const std::string name = condition.name;
      const double side_px = name == "side_px" ? amount : condition.side_px;
      const double tilt = name == "tilt_deg" ? RadiansOf(amount) : random.Uniform(0, RadiansOf(10));
      StressCase stress = Plain(side_px, tilt, code, random);
      condition.change(stress, amount, random);
      char tag[64];
      std::snprintf(tag, sizeof tag, "%s=%g", condition.name, amount);
      stress.tag = tag;
      cases.push_back(std::move(stress));
    }
  return cases;
}

}  // namespace chequer
