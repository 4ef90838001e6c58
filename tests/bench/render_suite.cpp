#include <chrono>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "bench/frames.h"
#include "simulate/board.h"
#include "simulate/layouts.h"
#include "simulate/random.h"
#include "simulate/render.h"
#include "simulate/stress.h"

namespace chequer::bench {
namespace {

constexpr double kGapM = 0.01;
/// So far away that 200 boards with ArUco's rims fit into five megapixels; and under the small camera.
constexpr double kFloorM = 3.1, kNearFloorM = 0.9;
/// Between the frames of a swarm that are no stream.
constexpr std::chrono::duration<double> kFarApart{1};
/// Of the streams' cameras: 30 frames a second.
constexpr std::chrono::nanoseconds kFrameInterval{33'333'333};

MarkerCode ChequerCode() { return MarkerCode(MarkerSize{6, 6}, Variant::kSecded); }

RenderOptions OptionsFor(const CameraModel& camera) {
  RenderOptions options;
  options.camera = camera;
  return options;
}

/// The same markers in another print. The peers carry a white rim, so the colour boards get a margin as well.
std::vector<SceneMarker> InPrint(std::vector<SceneMarker> markers, const Print& print) {
  for (SceneMarker& marker : markers) {
    marker.board = print.board(marker.board.id);
    marker.margin_cells = print.pattern == kChequerPattern ? 1 : 0;
  }
  return markers;
}

std::vector<TrueMarker> Truth(const std::vector<SceneMarker>& markers, const CameraModel& camera) {
  std::vector<TrueMarker> truth;
  for (const SceneMarker& marker : markers) {
    truth.push_back(
        {marker.board.id, marker.camera_from_marker, CenterPx(marker, camera), SmallestCellPx(marker, camera)});
  }
  return truth;
}

BenchFrame MakeFrame(const std::string& condition, const Scene& scene, RenderOptions options, std::uint64_t seed,
                     bool with_bayer) {
  BenchFrame frame;
  frame.condition = condition;
  frame.truth = Truth(scene.markers, options.camera);
  frame.colour = Render(scene, options, seed);
  options.format = PixelFormat::kBayerRg8;
  if (with_bayer && !options.jpeg_quality) frame.bayer = Render(scene, options, seed);
  return frame;
}

void AddFrames(Suite& suite, const std::string& condition, const Scene& scene, const RenderOptions& options,
               std::uint64_t seed, const std::vector<Print>& prints) {
  for (const Print& print : prints) {
    Scene printed = scene;
    printed.markers = InPrint(scene.markers, print);
    // The renderer knows spreading ink of checkerboards alone; the peers are spared it.
    if (print.pattern != kChequerPattern)
      for (SceneMarker& marker : printed.markers) marker.ink_spread_cells = 0;
    suite.frames[print.pattern].push_back(
        MakeFrame(condition, printed, options, seed, print.pattern == kChequerPattern));
  }
}

Suite RenderPaper(std::uint64_t seed, const std::vector<Print>& prints) {
  Suite suite;
  suite.straight_tracks = true;
  suite.camera = PublicationCamera();
  const RenderOptions options = OptionsFor(suite.camera);
  for (const TrackCase track : {TrackCase::kCloseDist, TrackCase::kMedDist, TrackCase::kFarDist, TrackCase::kInc30d}) {
    for (int run = 1; run <= 2; ++run) {
      const std::string condition = std::string(TrackName(track)) + std::to_string(run);
      std::vector<RigidTransform> truth;
      std::vector<PoseBounds> least;
      for (const SceneMarker& marker :
           PublicationTrack(track, ChequerCode(), DeriveSeed(seed, static_cast<std::uint64_t>(run)))) {
        Scene scene;
        scene.markers = {marker};
        scene.background = {.kind = BackgroundKind::kNoise, .seed = seed};
        AddFrames(suite, condition, scene, options, seed + suite.frames[kChequerPattern].size(), prints);
        truth.push_back(marker.camera_from_marker);
        least.push_back(PoseBoundsOf(InPrint({marker}, prints.front()).front(), options));
      }
      suite.bounds[condition] = BoundsOfTrack(truth, least);
    }
  }
  return suite;
}

/// @param distance_m of the floor.
Suite RenderSwarm(const CameraModel& camera, int robots, double side_m, double distance_m, int frame_count,
                  std::uint64_t seed, const std::vector<Print>& prints, std::chrono::nanoseconds interval = {}) {
  Suite suite;
  suite.camera = camera;
  suite.interval = interval;
  SwarmOptions swarm_options;
  swarm_options.camera = camera;
  swarm_options.side_m = side_m;
  swarm_options.gap_m = kGapM;
  swarm_options.distance_m = distance_m;
  // Room is made for the boards with the widest rims, then each is printed in every pattern.
  const Print& widest = WidestRim(prints);
  for (std::uint64_t robot = 0; robot < static_cast<std::uint64_t>(robots); ++robot) {
    swarm_options.boards.push_back(widest.board(robot));
    swarm_options.boards.back().id = robot;  // also where that print has fewer ids
  }
  const Swarm swarm(swarm_options, seed);
  const RenderOptions options = OptionsFor(camera);
  for (int i = 0; i < frame_count; ++i) {
    Scene scene;
    scene.markers = swarm.At(i * (interval.count() > 0 ? std::chrono::duration<double>(interval) : kFarApart));
    scene.background = {.kind = BackgroundKind::kNoise, .seed = seed};
    AddFrames(suite, "swarm", scene, options, seed + static_cast<std::uint64_t>(i), prints);
  }
  return suite;
}

CameraModel FullHdCamera() {
  return {.width = 1920,
          .height = 1080,
          .fx = 1400,
          .fy = 1400,
          .cx = 955,
          .cy = 546,
          .kind = CameraModel::Kind::kBrownConrady,
          .distortion = {-0.12, 0.03, 0.0005, -0.0003, 0}};
}

CameraModel FiveMegapixelCamera() {
  return {.width = 2448,
          .height = 2048,
          .fx = 2400,
          .fy = 2400,
          .cx = 1230,
          .cy = 1015,
          .kind = CameraModel::Kind::kBrownConrady,
          .distortion = {-0.1, 0.02, 0, 0, 0}};
}

Suite RenderStress(std::uint64_t seed, const std::vector<Print>& prints) {
  Suite suite;
  const std::vector<StressCase> cases = StressCases(ChequerCode(), seed);
  suite.camera = cases.front().options.camera;
  for (const StressCase& stress : cases) AddFrames(suite, stress.tag, stress.scene, stress.options, seed, prints);
  return suite;
}

Suite RenderEmpty(std::uint64_t seed, const std::vector<Print>&) {
  Suite suite;
  suite.camera = PublicationCamera();
  const RenderOptions options = OptionsFor(suite.camera);
  for (const BackgroundKind kind : {BackgroundKind::kNoise, BackgroundKind::kChess, BackgroundKind::kText,
                                    BackgroundKind::kTiles, BackgroundKind::kBlobs, BackgroundKind::kMixed}) {
    Scene scene;
    scene.background = {.kind = kind, .seed = seed};
    suite.frames[kChequerPattern].push_back(MakeFrame(std::string(BackgroundName(kind)), scene, options, seed, true));
  }
  return suite;
}

struct Recipe {
  const char* name;
  std::function<Suite(std::uint64_t, const std::vector<Print>&)> render;
};

const std::vector<Recipe>& Recipes() {
  static const std::vector<Recipe> recipes{
      {"paper", RenderPaper},
      {"swarm50",
       [](std::uint64_t seed, const std::vector<Print>& prints) {
         return RenderSwarm(FullHdCamera(), 50, DefaultSide("swarm50"), kFloorM, 4, seed, prints);
       }},
      {"swarm100",
       [](std::uint64_t seed, const std::vector<Print>& prints) {
         return RenderSwarm(FullHdCamera(), 100, DefaultSide("swarm100"), kFloorM, 3, seed, prints);
       }},
      {"swarm200",
       [](std::uint64_t seed, const std::vector<Print>& prints) {
         return RenderSwarm(FiveMegapixelCamera(), 200, DefaultSide("swarm200"), kFloorM, 2, seed, prints);
       }},
      // The frames until boards are known, and some turns of searching all places.
      {"stream1",
       [](std::uint64_t seed, const std::vector<Print>& prints) {
         return RenderSwarm(PublicationCamera(), 1, DefaultSide("stream1"), kNearFloorM, 20, seed, prints,
                            kFrameInterval);
       }},
      {"stream50",
       [](std::uint64_t seed, const std::vector<Print>& prints) {
         return RenderSwarm(FullHdCamera(), 50, DefaultSide("stream50"), kFloorM, 20, seed, prints, kFrameInterval);
       }},
      {"stream200",
       [](std::uint64_t seed, const std::vector<Print>& prints) {
         return RenderSwarm(FiveMegapixelCamera(), 200, DefaultSide("stream200"), kFloorM, 12, seed, prints,
                            kFrameInterval);
       }},
      {"stress", RenderStress},
      {"empty", RenderEmpty},
  };
  return recipes;
}

}  // namespace

std::vector<std::string> RenderedSuites() {
  std::vector<std::string> names;
  for (const Recipe& recipe : Recipes()) names.emplace_back(recipe.name);
  return names;
}

Suite RenderSuite(std::string_view name, std::uint64_t seed, const std::vector<Print>& prints) {
  std::string known;
  for (const Recipe& recipe : Recipes()) {
    if (recipe.name == name) {
      Suite suite = recipe.render(seed, prints);
      suite.name = name;
      suite.side_m = DefaultSide(name);
      return suite;
    }
    known += known.empty() ? recipe.name : std::string(", ") + recipe.name;
  }
  throw std::runtime_error("no suite is called \"" + std::string(name) + "\"; there are " + known);
}

}  // namespace chequer::bench
