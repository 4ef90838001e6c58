// Renders the frames, cameras and truths of the golden scenes: golden_render SCENES_FOLDER [NAME…]
// Run by hand only; the frames in the repository are what counts.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <opencv2/imgcodecs.hpp>

#include "chequer/camera_file.h"
#include "simulate/layouts.h"
#include "simulate/random.h"
#include "simulate/render.h"
#include "simulate/truth.h"

namespace chequer::golden {
namespace {

namespace fs = std::filesystem;

/// A frame to be: what is seen, by which camera.
struct Shot {
  Scene scene;
  RenderOptions options;
};

struct Recipe {
  const char* name;
  std::uint64_t seed;
  std::function<std::vector<Shot>(Random&)> shots;
};

constexpr double kSideM = 0.12;
constexpr double kDegree = M_PI / 180;

CameraModel Camera(int width, int height, double focal_px = 700) {
  CameraModel camera{.width = width, .height = height, .fx = focal_px, .fy = focal_px * 1.002};
  camera.cx = 0.5 * width + 4.3;
  camera.cy = 0.5 * height - 3.1;
  camera.kind = CameraModel::Kind::kBrownConrady;
  camera.distortion = {-0.12, 0.03, 0.0005, -0.0003, 0};
  return camera;
}

RenderOptions Options(const CameraModel& camera, PixelFormat format = PixelFormat::kBayerRg8) {
  RenderOptions options;
  options.camera = camera;
  options.format = format;
  return options;
}

MarkerCode Secded() { return MarkerCode(MarkerSize{6, 6}, Variant::kSecded); }

Board RandomBoard(const MarkerCode& code, Random& random) {
  return MakeBoard(code, code.max_id() == ~std::uint64_t{0} ? random.Bits() : random.Bits() % (code.max_id() + 1));
}

/// A board at a pixel, so far away that its cells have that size, turned at random.
SceneMarker Place(const Board& board, const CameraModel& camera, const Eigen::Vector2d& pixel, double cell_px,
                  double tilt_rad, Random& random) {
  SceneMarker marker;
  marker.board = board;
  marker.side_m = kSideM;
  const double depth = camera.fx * marker.CellSize() / cell_px;
  const Eigen::Vector2d normalized = camera.Undistort(pixel).value();
  // One by one: a compiler draws the arguments of a call in an order of its own.
  const double tilt_axis_rad = random.Uniform(0, 2 * M_PI), heading_rad = random.Uniform(0, 2 * M_PI);
  marker.camera_from_marker =
      FacingPose({normalized.x() * depth, normalized.y() * depth, depth}, heading_rad, tilt_rad, tilt_axis_rad);
  return marker;
}

/// Boards in the middles of a lattice of cols × rows fields, a little off them.
std::vector<SceneMarker> Lattice(const CameraModel& camera, int cols, int rows, double cell_px, double tilt_rad,
                                 Random& random, const std::function<Board(int)>& board) {
  std::vector<SceneMarker> markers;
  const double width = static_cast<double>(camera.width) / cols;
  const double height = static_cast<double>(camera.height) / rows;
  for (int i = 0; i < cols * rows; ++i) {
    const double down_px = random.Uniform(-2, 2), right_px = random.Uniform(-2, 2);
    const Eigen::Vector2d pixel((i % cols + 0.5) * width + right_px, (i / cols + 0.5) * height + down_px);
    markers.push_back(Place(board(i), camera, pixel, cell_px, tilt_rad, random));
  }
  return markers;
}

std::function<Board(int)> AnySecded(Random& random) {
  return [&random](int) { return RandomBoard(Secded(), random); };
}

Background Behind(BackgroundKind kind, Random& random) {
  Background background;
  background.kind = kind;
  background.seed = random.Bits();
  return background;
}

/// A frame of cols × rows secded boards on noise.
Shot Boards(const RenderOptions& options, int cols, int rows, double cell_px, double tilt_rad, Random& random) {
  Shot shot{{}, options};
  shot.scene.markers = Lattice(options.camera, cols, rows, cell_px, tilt_rad, random, AnySecded(random));
  shot.scene.background = Behind(BackgroundKind::kNoise, random);
  return shot;
}

std::vector<Shot> Tracks(Random& random, PixelFormat format, std::initializer_list<TrackCase> cases) {
  std::vector<Shot> shots;
  for (const TrackCase track : cases) {
    const std::vector<SceneMarker> markers = PublicationTrack(track, Secded(), random.Bits());
    Shot shot{{}, Options(PublicationCamera(), format)};
    shot.scene.markers = {markers[static_cast<std::size_t>(random.Below(static_cast<int>(markers.size())))]};
    shot.scene.background = Behind(BackgroundKind::kNoise, random);
    shots.push_back(std::move(shot));
  }
  return shots;
}

std::vector<Shot> Swarm24(Random& random, PixelFormat format) {
  SwarmOptions options;
  options.camera = Camera(960, 600, 1000);
  options.side_m = kSideM;
  options.distance_m = 2.6;
  for (int i = 0; i < 24; ++i) options.boards.push_back(RandomBoard(Secded(), random));
  const Swarm swarm(options, random.Bits());
  Shot shot{{}, Options(options.camera, format)};
  shot.scene.markers = swarm.At(std::chrono::seconds(1));
  shot.scene.background = Behind(BackgroundKind::kTiles, random);
  return {shot};
}

/// Nine boards edge to edge on one plane.
std::vector<Shot> Touching(Random& random) {
  const CameraModel camera = Camera(480, 360);
  Shot shot{{}, Options(camera)};
  const RigidTransform camera_from_plane = FacingPose({0.02, 0.01, 1.1}, 0.35, 0.2, 1.0);
  for (int i = 0; i < 9; ++i) {
    SceneMarker marker;
    marker.board = RandomBoard(Secded(), random);
    marker.side_m = 0.1;
    marker.camera_from_marker = camera_from_plane;
    marker.camera_from_marker.translation =
        camera_from_plane * Eigen::Vector3d((i % 3 - 1) * marker.side_m, (i / 3 - 1) * marker.side_m, 0);
    shot.scene.markers.push_back(std::move(marker));
  }
  return {shot};
}

/// A strip of each board is hidden.
std::vector<Shot> Hidden(Random& random) {
  Shot shot = Boards(Options(Camera(640, 400)), 4, 2, 15, 0.2, random);
  for (std::size_t i = 0; i < shot.scene.markers.size(); ++i) {
    Occluder strip{.from = {-0.1, -0.1}, .to = {1.1, i % 2 == 0 ? 0.12 : 0.18}};
    strip.patches = 8;
    strip.seed = random.Bits();
    shot.scene.markers[i].occluders.push_back(strip);
  }
  return {shot};
}

/// One board of each of several families.
std::vector<Shot> Families(Random& random) {
  const CameraModel camera = Camera(800, 500);
  const std::array codes{MarkerCode({5, 5}, Variant::kSecded), MarkerCode({4, 8}, Variant::kSaturationConstrained),
                         MarkerCode({8, 8}, Variant::kGolay),  MarkerCode({10, 10}, Variant::kSecded),
                         MarkerCode({6, 7}, Variant::kSecded), MarkerCode({6, 6}, Variant::kColorConstrained)};
  Shot shot{{}, Options(camera)};
  shot.scene.markers = Lattice(camera, 3, 2, 16, 0.2, random,
                               [&](int i) { return RandomBoard(codes[static_cast<std::size_t>(i)], random); });
  shot.scene.background = Behind(BackgroundKind::kWood, random);
  return {shot};
}

/// Reed-Muller boards, each with three kernel cells that are printed wrong.
std::vector<Shot> WrongCells(Random& random) {
  const MarkerCode code({6, 6}, Variant::kReedMuller);
  const CameraModel camera = Camera(480, 320);
  Shot shot{{}, Options(camera)};
  shot.scene.markers = Lattice(camera, 3, 2, 14, 0.15, random, [&](int) {
    Board board = RandomBoard(code, random);
    std::uint64_t wrong = 0;
    while (std::popcount(wrong) < 3) wrong |= std::uint64_t{1} << random.Below(16);
    board.cells = CellColours(code.size(), code.Encode(board.id) ^ wrong);
    return board;
  });
  shot.scene.background = Behind(BackgroundKind::kPlain, random);
  return {shot};
}

/// Ids by a table of one's own; its kernels are those of table.txt in the scene's folder.
std::vector<Shot> OwnTable(Random& random) {
  const MarkerCode code = MarkerCode::FromTable({4, 6}, {0b01101001, 0b10010110, 0b11110000, 0b00001111, 0b10101010});
  const CameraModel camera = Camera(480, 320);
  Shot shot{{}, Options(camera)};
  shot.scene.markers = Lattice(camera, 3, 2, 13, 0.15, random, [&](int) { return RandomBoard(code, random); });
  shot.scene.background = Behind(BackgroundKind::kTiles, random);
  return {shot};
}

/// Boards as a mirror shows them: none may be read.
std::vector<Shot> Mirrored(Random& random) {
  Shot shot = Boards(Options(Camera(480, 320)), 3, 2, 14, 0.15, random);
  for (SceneMarker& marker : shot.scene.markers) marker.mirrored = true;
  return {shot};
}

std::vector<Shot> PeersOnly(Random& random) {
  const CameraModel camera = Camera(480, 320);
  Shot shot{{}, Options(camera)};
  shot.scene.markers = Lattice(camera, 4, 3, 8, 0.15, random, [&](int i) {
    return i % 2 == 0 ? AprilTag36h11(random.Bits() % 587) : Aruco4x4(random.Bits() % 1000);
  });
  shot.scene.background = Behind(BackgroundKind::kNoise, random);
  return {shot};
}

std::vector<Shot> Empty(Random& random, PixelFormat format, std::initializer_list<BackgroundKind> kinds) {
  std::vector<Shot> shots;
  for (const BackgroundKind kind : kinds) {
    Shot shot{{}, Options(Camera(400, 300), format)};
    shot.scene.background = Behind(kind, random);
    shots.push_back(std::move(shot));
  }
  return shots;
}

/// A frame of six boards of 10 px cells with one thing made hard.
std::vector<Shot> Hard(Random& random, const std::function<void(Shot&)>& change,
                       PixelFormat format = PixelFormat::kBayerRg8) {
  Shot shot = Boards(Options(Camera(480, 320), format), 3, 2, 10, 0.2, random);
  change(shot);
  return {shot};
}

std::vector<Recipe> Recipes() {
  using enum TrackCase;
  using enum BackgroundKind;
  constexpr PixelFormat kBgr = PixelFormat::kBgr8;
  constexpr PixelFormat kRaw = PixelFormat::kBayerRg8;
  return {
      {"tracks_bayer", 101,
       [](Random& r) {
         return Tracks(r, kRaw, {kCloseDist, kMedDist, kFarDist, kInc30d});
       }},
      {"tracks_colour", 102,
       [](Random& r) {
         return Tracks(r, kBgr, {kFarDist, kInc30d});
       }},
      {"swarm_bayer", 103, [](Random& r) { return Swarm24(r, kRaw); }},
      {"swarm_jpeg", 104, [](Random& r) { return Swarm24(r, kBgr); }},
      {"touching", 105, Touching},
      {"partly_hidden", 106, Hidden},
      {"families", 107, Families},
      {"wrong_cells", 108, WrongCells},
      {"own_table", 109, OwnTable},
      {"tilted", 110,
       [](Random& r) { return std::vector{Boards(Options(Camera(480, 320)), 3, 2, 16, 60 * kDegree, r)}; }},
      {"small_cells", 111, [](Random& r) { return std::vector{Boards(Options(Camera(480, 320)), 6, 4, 4.8, 0.1, r)}; }},
      {"dim", 112,
       [](Random& r) {
         return Hard(r, [](Shot& s) {
           s.options.sensor.full_well_electrons = 600;
           s.options.sensor.exposure = 0.5;
         });
       }},
      {"gradient", 113,
       [](Random& r) {
         return Hard(r, [](Shot& s) {
           s.options.lighting.gradient = 0.85;
           s.options.lighting.gradient_angle_rad = 0.6;
         });
       }},
      {"colour_cast", 114,
       [](Random& r) { return Hard(r, [](Shot& s) {
                         s.options.sensor.white_balance = {1.3, 1, 0.65};
                       }); }},
      {"defocused", 115, [](Random& r) { return Hard(r, [](Shot& s) { s.options.blur_sigma_px = 1.8; }); }},
      {"motion", 116,
       [](Random& r) {
         return Hard(r, [](Shot& s) {
           s.options.motion_px = 4;
           s.options.motion_angle_rad = 0.5;
         });
       }},
      {"faded_ink", 117,
       [](Random& r) {
         return Hard(r, [](Shot& s) {
           for (SceneMarker& m : s.scene.markers) m.inks = NamedInks("faded").value();
         });
       }},
      {"hsv", 118,
       [](Random& r) {
         return Hard(
             r, [](Shot&) {}, kBgr);
       }},
      {"linear_bayer_gb", 119,
       [](Random& r) {
         return Hard(
             r, [](Shot& s) { s.options.tone_curve = ToneCurve::Linear(); }, PixelFormat::kBayerGb8);
       }},
      {"empty_colour", 120,
       [](Random& r) {
         return Empty(r, kBgr, {kChess, kText, kBlobs, kMixed});
       }},
      {"empty_bayer", 121,
       [](Random& r) {
         return Empty(r, kRaw, {kNoise, kTiles, kWood, kChess, kMixed});
       }},
      {"empty_mirrored", 122, Mirrored},
      {"empty_other_tags", 123, PeersOnly},
  };
}

void WriteFrame(const fs::path& path, const Image& image) {
  const int type = image.format() == PixelFormat::kBgr8 ? CV_8UC3 : CV_8UC1;
  Image copy = image;
  const cv::Mat pixels(image.height(), image.width(), type, copy.bytes().data());
  const std::vector<int> parameters = path.extension() == ".jpg" ? std::vector<int>{cv::IMWRITE_JPEG_QUALITY, 88}
                                                                 : std::vector<int>{cv::IMWRITE_PNG_COMPRESSION, 9};
  if (!cv::imwrite(path.string(), pixels, parameters)) throw std::runtime_error(path.string() + ": cannot be written");
}

void WriteScene(const fs::path& folder, const Recipe& recipe) {
  fs::create_directories(folder);
  Random random(recipe.seed);
  const std::vector<Shot> shots = recipe.shots(random);
  const bool empty = folder.filename().string().starts_with("empty_");
  const char* const extension = folder.filename().string().ends_with("_jpeg") ? ".jpg" : ".png";
  std::vector<FrameTruth> truth;
  for (std::size_t i = 0; i < shots.size(); ++i) {
    FrameTruth& frame = truth.emplace_back();
    frame.file = std::to_string(i) + extension;
    // What stands in scenes called empty is not to be found: other tags, mirror images.
    if (!empty) frame.markers = TruthOf(shots[i].scene.markers, shots[i].options.camera);
    WriteFrame(folder / frame.file, Render(shots[i].scene, shots[i].options, random.Bits()));
  }
  WriteTruth(folder / "truth.jsonl", truth);
  WriteCamera(folder / "camera.toml", shots.front().options.camera);
  std::printf("%s: %zu frames\n", folder.c_str(), shots.size());
}

}  // namespace
}  // namespace chequer::golden

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.empty()) {
    std::fprintf(stderr, "usage: golden_render SCENES_FOLDER [NAME...]\n");
    return 2;
  }
  try {
    for (const chequer::golden::Recipe& recipe : chequer::golden::Recipes()) {
      const bool wanted =
          arguments.size() == 1 || std::find(arguments.begin() + 1, arguments.end(), recipe.name) != arguments.end();
      if (wanted) chequer::golden::WriteScene(std::filesystem::path(arguments[0]) / recipe.name, recipe);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "golden_render: %s\n", error.what());
    return 1;
  }
  return 0;
}
