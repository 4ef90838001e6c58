// The detector stage by stage, on a 1080p frame of 50 boards. Per-board stages also say how many boards a second.
#include <benchmark/benchmark.h>

#include <array>
#include <chrono>
#include <map>
#include <random>

#include "chequer/detector.h"
#include "detect/boards/boards.h"
#include "detect/common/board_geometry.h"
#include "detect/common/homography.h"
#include "detect/common/light.h"
#include "detect/common/plane.h"
#include "detect/corners/corner_response.h"
#include "detect/corners/corners.h"
#include "detect/fit/fit.h"
#include "detect/grids/grids.h"
#include "detect/identity/marker_description.h"
#include "detect/pose/plane_pose.h"
#include "simulate/layouts.h"
#include "simulate/render.h"

namespace chequer::bench {
namespace {

constexpr int kBoards = 50;
constexpr double kSideM = 0.1;
constexpr std::uint64_t kSeed = 5;

DetectorOptions Options() {
  DetectorOptions options;
  options.families = {MarkerFamily{MarkerCode(MarkerSize{6, 6}, Variant::kSecded), kSideM, {}}};
  options.camera = CameraModel{.width = 1920,
                               .height = 1080,
                               .fx = 1400,
                               .fy = 1400,
                               .cx = 955,
                               .cy = 546,
                               .kind = CameraModel::Kind::kBrownConrady,
                               .distortion = {-0.12, 0.03, 0.0005, -0.0003, 0}};
  return options;
}

Image RenderFrame(PixelFormat format) {
  const DetectorOptions options = Options();
  SwarmOptions swarm;
  swarm.camera = *options.camera;
  swarm.side_m = kSideM;
  for (std::uint64_t id = 0; id < kBoards; ++id) swarm.boards.push_back(MakeBoard(options.families[0].code, id));
  Scene scene;
  scene.markers = Swarm(swarm, kSeed).At(std::chrono::seconds(0));
  scene.background = {.kind = BackgroundKind::kNoise, .seed = kSeed};
  RenderOptions render;
  render.camera = swarm.camera;
  render.format = format;
  return Render(scene, render, kSeed);
}

/// The frame in a format, rendered once.
const Image& Frame(PixelFormat format) {
  static std::map<PixelFormat, Image> frames;
  const auto [frame, is_new] = frames.try_emplace(format);
  if (is_new) frame->second = RenderFrame(format);
  return frame->second;
}

/// What every stage hands to the next, for the Bayer frame.
struct Stages {
  Stages()
      : options(Options()),
        view(Frame(PixelFormat::kBayerRg8).view()),
        table(view.tone_curve().LinearTable()),
        reader(view, table),
        lens(*options.camera),
        finder({BorderPattern(options.families[0].code.size())}, options.color_space) {
    FindCorners(view, pyramid, corners);
    linked = corners;
    linker.Link(pyramid.base, linked, grids);
    FindBoards();
  }

  void FindBoards() {
    finder.Start(linked.size());
    boards.clear();
    for (const Grid& grid : grids.grids)
      finder.Find(grid, grids.Of(grid), linked, &linker.search(), reader, lens, boards);
  }

  DetectorOptions options;
  ImageView view;
  std::array<float, 256> table;
  LightReader reader;
  Lens lens;
  Pyramid pyramid;
  std::vector<Corner> corners;  ///< as found
  std::vector<Corner> linked;   ///< in the linker's order
  GridLinker linker;
  Grids grids;
  BoardFinder finder;
  std::vector<AnchoredBoard> boards;
};

Stages& Prepared() {
  static Stages stages;
  return stages;
}

double CellM() { return kSideM / 6; }

/// Where the fit of a board starts.
PhotometricFit::Start StartOf(const AnchoredBoard& board, const ImageTraits* image) {
  return {.board = {.size = board.size,
                    .geometry = BoardGeometry(board.plane_from_board),
                    .blur_px = 0.8 * static_cast<double>(board.scale),
                    .light = board.light,
                    .saturated = board.saturated,
                    .visibility = board.visibility,
                    .image = image}};
}

/// All boards fitted, the first one telling the noise.
std::vector<FittedBoard> FitAll(const Stages& stages) {
  PhotometricFit fit;
  std::vector<FittedBoard> fitted;
  for (const AnchoredBoard& board : stages.boards)
    if (const FittedBoard* result =
            fit.Fit(stages.reader, stages.lens, StartOf(board, fitted.empty() ? nullptr : &fitted.front().image)))
      fitted.push_back(*result);
  return fitted;
}

void CountBoards(benchmark::State& state, std::size_t boards) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(boards));
  state.counters["boards"] = static_cast<double>(boards);
}

void Plane(benchmark::State& state, PixelFormat format) {
  const Image& frame = Frame(format);
  DetectionPlane plane;
  for (auto _ : state) BuildDetectionPlane(frame.view(), plane);
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(frame.bytes().size()));
}
BENCHMARK_CAPTURE(Plane, Bgr8, PixelFormat::kBgr8)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Plane, BayerRg8, PixelFormat::kBayerRg8)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Plane, Yuyv, PixelFormat::kYuyv)->Unit(benchmark::kMicrosecond);

void Halve(benchmark::State& state) {
  BytePlane half;
  const BytePlane& full = Prepared().pyramid.base.plane;
  half.Resize(full.width() / 2, full.height() / 2);
  for (auto _ : state) HalveRows(full, 0, half.height(), half);
}
BENCHMARK(Halve)->Unit(benchmark::kMicrosecond);

void Response(benchmark::State& state) {
  const BytePlane& plane = Prepared().pyramid.base.plane;
  PeakScan scan;
  for (auto _ : state) {
    scan.Start(plane, 4);
    scan.Advance(plane, plane.height());
  }
}
BENCHMARK(Response)->Unit(benchmark::kMicrosecond);

void Corners(benchmark::State& state) {
  Stages& stages = Prepared();
  std::vector<Corner> corners;
  for (auto _ : state) benchmark::DoNotOptimize(FindCorners(stages.view, stages.pyramid, corners));
  state.counters["corners"] = static_cast<double>(corners.size());
}
BENCHMARK(Corners)->Unit(benchmark::kMicrosecond);

void Link(benchmark::State& state) {
  Stages& stages = Prepared();
  std::vector<Corner> corners;
  Grids grids;
  for (auto _ : state) {
    corners = stages.corners;  // the linker sorts its input; the copy is cheap beside it
    stages.linker.Link(stages.pyramid.base, corners, grids);
  }
  state.counters["grids"] = static_cast<double>(grids.grids.size());
}
BENCHMARK(Link)->Unit(benchmark::kMicrosecond);

void Anchor(benchmark::State& state) {
  Stages& stages = Prepared();
  for (auto _ : state) stages.FindBoards();
  CountBoards(state, stages.boards.size());
}
BENCHMARK(Anchor)->Unit(benchmark::kMicrosecond);

void Fit(benchmark::State& state) {
  const Stages& stages = Prepared();
  const ImageTraits image = FitAll(stages).at(0).image;
  PhotometricFit fit;
  for (auto _ : state) {
    for (const AnchoredBoard& board : stages.boards)
      benchmark::DoNotOptimize(fit.Fit(stages.reader, stages.lens, StartOf(board, &image)));
  }
  CountBoards(state, stages.boards.size());
}
BENCHMARK(Fit)->Unit(benchmark::kMicrosecond);

void Poses(benchmark::State& state) {
  const Stages& stages = Prepared();
  const std::vector<FittedBoard> fitted = FitAll(stages);
  for (auto _ : state) {
    for (const FittedBoard& board : fitted)
      benchmark::DoNotOptimize(
          PlanePoses({board.geometry, board.information}, {CellM(), CellM()}, stages.lens.focal()));
  }
  CountBoards(state, fitted.size());
}
BENCHMARK(Poses)->Unit(benchmark::kMicrosecond);

void Identify(benchmark::State& state) {
  const Stages& stages = Prepared();
  const std::vector<FittedBoard> fitted = FitAll(stages);
  Identifier identifier(stages.options);
  const MarkerSize size = stages.options.families[0].code.size();
  for (auto _ : state) {
    for (const FittedBoard& board : fitted) {
      benchmark::DoNotOptimize(identifier.Identify(board, size, stages.reader, stages.lens));
    }
  }
  CountBoards(state, fitted.size());
}
BENCHMARK(Identify)->Unit(benchmark::kMicrosecond);

void SoftDecode(benchmark::State& state, MarkerSize size, Variant variant) {
  const MarkerCode code(size, variant);
  std::mt19937 random(1);
  std::normal_distribution<float> normal(0, 3);
  std::vector<std::vector<float>> ratios(64, std::vector<float>(static_cast<std::size_t>(KernelBits(size))));
  for (std::vector<float>& board : ratios) {
    for (float& ratio : board) ratio = normal(random);
  }
  for (auto _ : state) {
    for (const std::vector<float>& board : ratios) benchmark::DoNotOptimize(code.DecodeSoft(board));
  }
  CountBoards(state, ratios.size());
}
BENCHMARK_CAPTURE(SoftDecode, unconstrained_6x6, MarkerSize{6, 6}, Variant::kUnconstrained);
BENCHMARK_CAPTURE(SoftDecode, color_constrained_6x6, MarkerSize{6, 6}, Variant::kColorConstrained);
BENCHMARK_CAPTURE(SoftDecode, secded_6x6, MarkerSize{6, 6}, Variant::kSecded);
BENCHMARK_CAPTURE(SoftDecode, nordstrom_robinson_6x6, MarkerSize{6, 6}, Variant::kNordstromRobinson);
BENCHMARK_CAPTURE(SoftDecode, golay_8x8, MarkerSize{8, 8}, Variant::kGolay);
BENCHMARK_CAPTURE(SoftDecode, secded_10x10, MarkerSize{10, 10}, Variant::kSecded);

void Whole(benchmark::State& state, PixelFormat format) {
  const Image& frame = Frame(format);
  Detector detector(Options());
  std::vector<MarkerPose> markers;
  for (auto _ : state) detector.Detect(frame.view(), markers);
  CountBoards(state, markers.size());
}
BENCHMARK_CAPTURE(Whole, Bgr8, PixelFormat::kBgr8)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Whole, BayerRg8, PixelFormat::kBayerRg8)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(Whole, Yuyv, PixelFormat::kYuyv)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace chequer::bench

BENCHMARK_MAIN();
