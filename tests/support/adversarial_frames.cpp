#include "support/adversarial_frames.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "simulate/random.h"
#include "simulate/render.h"
#include "support/adversarial_textures.h"
#include "support/scenes.h"

namespace chequer::test {
namespace {

constexpr double kSideM = 0.1;
constexpr int kCells = 6;

/// A swarm in trouble.
struct SwarmKind {
  std::string_view name;
  int boards = 0;  ///< 0: as many as in a calm frame
  double cell_px = 10;
  double motion_px = 0;
  double ink_spread_cells = 0;
  double blur_px = 0.6;  ///< of the lens
  bool nameless = false, mirrored = false;
};
constexpr std::array kSwarms{
    SwarmKind{.name = kCalm},
    SwarmKind{.name = "knocked16", .boards = 16, .motion_px = 14},
    SwarmKind{.name = "knocked50", .boards = 50, .motion_px = 14},
    SwarmKind{.name = "knocked100", .boards = 100, .cell_px = 8, .motion_px = 14},
    SwarmKind{.name = "moved50", .boards = 50, .motion_px = 8},
    SwarmKind{.name = "soft50", .boards = 50, .blur_px = 1.7},
    SwarmKind{.name = "bled50", .boards = 50, .ink_spread_cells = 0.1},
    SwarmKind{.name = "bled8", .boards = 8, .cell_px = 20, .ink_spread_cells = 0.1},
    SwarmKind{.name = "bled12", .boards = 12, .cell_px = 29, .ink_spread_cells = 0.1},
    SwarmKind{.name = "nameless50", .boards = 50, .nameless = true},
    SwarmKind{.name = "mirrored50", .boards = 50, .mirrored = true},
    SwarmKind{.name = "thousand", .boards = 1000, .cell_px = 0},
};

/// Cells inside the border, of the right lightness, whose inks are those of no word.
void Scramble(Board& board, Random& random) {
  for (int row = 1; row + 1 < board.rows; ++row)
    for (int col = 1; col + 1 < board.cols; ++col) {
      char& cell = board.cells[static_cast<std::size_t>(row * board.cols + col)];
      const bool inked = random.Bits() >> 40 & 1;
      cell = IsDark(row, col) ? (inked ? 'B' : 'K') : (inked ? 'Y' : 'W');
    }
}

/// Boards on a grid over the whole frame, each turned as it likes and some of a cell off its place.
std::vector<SceneMarker> PlaceBoards(const SwarmKind& kind, int boards, double cell_px, const CameraModel& camera,
                                     const MarkerCode& code, Random& random) {
  const double area = static_cast<double>(camera.width) * camera.height / boards;
  const int cols = static_cast<int>(std::ceil(camera.width / std::sqrt(area))), rows = (boards + cols - 1) / cols;
  std::vector<SceneMarker> markers;
  for (int i = 0; i < boards; ++i) {
    const double depth = camera.fx * kSideM / kCells / cell_px;
    const double x = (i % cols + 0.5) * camera.width / cols + random.Uniform(-1, 1),
                 y = (i / cols + 0.5) * camera.height / rows + random.Uniform(-1, 1);
    const Eigen::Vector3d place((x - camera.cx) * depth / camera.fx, (y - camera.cy) * depth / camera.fy, depth);
    // Small boards stand so close that they would touch if they were turned far.
    const double heading = boards > 500 ? random.Uniform(-0.05, 0.05) : random.Uniform(0, 2 * M_PI);
    SceneMarker marker = MarkerOf(code, static_cast<std::uint64_t>(i) % (code.max_id() + 1),
                                  FacingPose(place, heading, 0.1, random.Uniform(0, 2 * M_PI)), kSideM);
    marker.ink_spread_cells = kind.ink_spread_cells;
    marker.mirrored = kind.mirrored;
    if (kind.nameless) Scramble(marker.board, random);
    markers.push_back(std::move(marker));
  }
  return markers;
}

HardFrame DrawSwarm(const SwarmKind& kind, int width, int height, std::uint64_t seed, DetectorOptions options) {
  Random random(seed);
  const double pixels = static_cast<double>(width) * height;
  const int boards =
      kind.boards > 0 ? kind.boards : std::max(1, static_cast<int>(std::lround(pixels / 1920 / 1080 * 50)));
  const int fitting = width * height < 1500000 && kind.boards == 0 ? std::min(boards, 16) : boards;
  // As large as there is room for, if they are many.
  const double room_px = std::sqrt(pixels / fitting);
  const double cell_px = kind.cell_px > 0 ? std::min(kind.cell_px, room_px / 9) : room_px / 7.2;
  Scene scene;
  scene.background = {.kind = BackgroundKind::kNoise, .seed = seed};
  scene.markers = PlaceBoards(kind, fitting, cell_px, *options.camera, options.families[0].code, random);
  RenderOptions render;
  render.camera = *options.camera;
  render.blur_sigma_px = kind.blur_px;
  render.motion_px = kind.motion_px;
  render.motion_angle_rad = 0.7;
  return {Render(scene, render, seed), std::move(options), static_cast<std::size_t>(fitting)};
}

}  // namespace

std::vector<std::string> HardFrameNames() {
  std::vector<std::string> names;
  for (const SwarmKind& kind : kSwarms) names.emplace_back(kind.name);
  for (std::string& name : TextureNames()) names.push_back(std::move(name));
  return names;
}

DetectorOptions HardFrameOptions(int width, int height) {
  DetectorOptions options;
  options.camera = PlainCamera(width, height, 0.75 * width);
  options.families = {{.code = MarkerCode({kCells, kCells}, Variant::kSecded), .side_m = kSideM, .roster = {}}};
  return options;
}

HardFrame DrawHardFrame(std::string_view name, int width, int height, std::uint64_t seed) {
  DetectorOptions options = HardFrameOptions(width, height);
  const auto kind =
      std::find_if(kSwarms.begin(), kSwarms.end(), [&](const SwarmKind& each) { return each.name == name; });
  if (kind != kSwarms.end()) return DrawSwarm(*kind, width, height, seed, std::move(options));
  return {DrawTexture(name, width, height, seed), std::move(options), 0};
}

}  // namespace chequer::test
