// costly_scenes FOLDER [NAME...]: frames of 1920x1080 whose boards once cost tens of times as much as sharp ones,
// mostly by dot gain, as PNG files with their camera.toml; and "sharp50" and "empty" to compare them with. Prints a
// line each: name, boards. tests/bench/costly_work counts what detecting in them takes.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "capture/recording_writer.h"
#include "chequer/camera_file.h"
#include "simulate/layouts.h"
#include "simulate/render.h"

namespace chequer::bench {
namespace {

constexpr double kSideM = 0.12;
constexpr std::uint64_t kSeed = 1;

/// As `chequer render --size 1920x1080 --marker 6x6:secded:0.12 --swarm N --distance D --blur B --ink-spread S
/// --gradient G` has it; in addition half of each board may be shadowed.
struct CostlyScene {
  std::string_view name;
  int boards = 0;
  double distance_m = 3;
  double ink_spread_cells = 0;
  double blur_px = 0.6;
  double gradient = 0;
  double half_shadow = 0;  ///< share of the light that it takes
};

constexpr std::array kScenes{
    CostlyScene{.name = "empty"},
    CostlyScene{.name = "sharp50", .boards = 50},
    CostlyScene{.name = "gain25", .boards = 25, .distance_m = 2, .ink_spread_cells = 0.03},
    CostlyScene{.name = "gain12", .boards = 12, .distance_m = 1, .ink_spread_cells = 0.1},
    CostlyScene{.name = "gain100", .boards = 100, .ink_spread_cells = 0.15, .blur_px = 1.6},
    CostlyScene{.name = "shadowed12",
                .boards = 12,
                .distance_m = 1,
                .ink_spread_cells = 0.2,
                .blur_px = 4,
                .gradient = 0.5,
                .half_shadow = 0.6},
    CostlyScene{.name = "large2", .boards = 2, .distance_m = 0.5, .ink_spread_cells = 0.07},
    CostlyScene{.name = "spread12", .boards = 12, .distance_m = 1, .ink_spread_cells = 0.2},
};

RenderOptions OptionsOf(const CostlyScene& scene) {
  RenderOptions options;
  options.camera = {.width = 1920, .height = 1080, .fx = 1440, .fy = 1440, .cx = 959.5, .cy = 539.5};
  options.blur_sigma_px = scene.blur_px;
  options.lighting.gradient = scene.gradient;
  return options;
}

std::vector<SceneMarker> PlaceMarkers(const CostlyScene& scene, const CameraModel& camera) {
  if (scene.boards == 0) return {};
  SwarmOptions swarm;
  swarm.camera = camera;
  const MarkerCode code(MarkerSize{6, 6}, Variant::kSecded);
  for (int i = 0; i < scene.boards; ++i) swarm.boards.push_back(MakeBoard(code, static_cast<std::uint64_t>(i)));
  swarm.side_m = kSideM;
  swarm.distance_m = scene.distance_m;
  swarm.height_spread_m = std::min(0.1, 0.1 * scene.distance_m);
  swarm.ink_spread_cells = scene.ink_spread_cells;
  return Swarm(swarm, kSeed).At(std::chrono::seconds(0));
}

/// The edge of a shadow goes through the middle of a board, which lies in it with one half. The floor about it does,
/// too, as far as a disc reaches that holds the board.
void ShadeHalf(const SceneMarker& marker, const CameraModel& camera, double takes, double direction_rad,
               double width_px, LinearImage& light) {
  const Eigen::Vector2d middle = CenterPx(marker, camera);
  const double reach = 0.75 * camera.fx * marker.side_m / marker.camera_from_marker.translation.z();
  const CastShadow shadow{.takes = takes,
                          .direction_rad = direction_rad,
                          .through_x = middle.x(),
                          .through_y = middle.y(),
                          .width_px = width_px};
  for (int y = 0; y < light.height; ++y)
    for (int x = 0; x < light.width; ++x) {
      if (std::hypot(x - middle.x(), y - middle.y()) > reach) continue;
      const auto left = static_cast<float>(shadow.LightAt(x, y));
      for (int c = 0; c < 3; ++c) light.Pixel(x, y)[c] *= left;
    }
}

Image Draw(const CostlyScene& kind) {
  const RenderOptions options = OptionsOf(kind);
  Scene scene;
  scene.markers = PlaceMarkers(kind, options.camera);
  LinearImage light = RenderLight(scene, options);
  double direction_rad = 0.3;
  for (const SceneMarker& marker : scene.markers) {
    // Out of focus, a sharp edge is as wide as the blur.
    if (kind.half_shadow > 0) ShadeHalf(marker, options.camera, kind.half_shadow, direction_rad, kind.blur_px, light);
    direction_rad += 0.9;
  }
  return Capture(std::move(light), options, kSeed);
}

void Write(const std::filesystem::path& folder, const CostlyScene& scene) {
  const auto bytes = EncodeFrame(Draw(scene).view(), {});
  const std::filesystem::path path = folder / (std::string(scene.name) + ".png");
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file) throw std::runtime_error(path.string() + " could not be written");
  WriteCamera(folder / "camera.toml", OptionsOf(scene).camera);
  fmt::print("{} {}\n", scene.name, scene.boards);
}

}  // namespace
}  // namespace chequer::bench

int main(int argc, char** argv) {
  using chequer::bench::kScenes;
  const std::vector<std::string> words(argv + 1, argv + argc);
  try {
    if (words.empty()) throw std::runtime_error("FOLDER [NAME...]");
    const auto wanted = [&](std::string_view name) {
      return words.size() == 1 || std::find(words.begin() + 1, words.end(), name) != words.end();
    };
    for (const auto& scene : kScenes)
      if (wanted(scene.name)) chequer::bench::Write(words[0], scene);
  } catch (const std::exception& error) {
    fmt::print(stderr, "costly_scenes: {}\n", error.what());
    return 1;
  }
}
