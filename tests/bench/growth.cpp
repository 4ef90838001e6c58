// growth [--seed N] [--repeat N]: how the detector's time grows with pixels and with markers, and what a second thread
// is worth. Renders floors from 640 × 480 to 12 megapixels with up to 1,000 markers of about 41 px, and fits
//   time = a · pixels + b · markers
// to what one thread takes; then lets two detectors work at once, and two threads of one.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/QR>
#include <algorithm>
#include <barrier>
#include <chrono>
#include <thread>
#include <vector>

#include "chequer/detector.h"
#include "simulate/layouts.h"
#include "simulate/render.h"

namespace chequer::bench {
namespace {

constexpr double kFloorM = 3.1;
constexpr double kMarkerPx = 41;

struct Case {
  int width = 0, height = 0;
  std::size_t markers = 0;
};

constexpr Case kCases[] = {{640, 480, 0},     {640, 480, 1},     {1920, 1080, 0},   {1920, 1080, 50},
                           {1920, 1080, 100}, {2448, 2048, 0},   {2448, 2048, 200}, {2448, 2048, 300},
                           {4096, 3000, 0},   {4096, 3000, 500}, {4096, 3000, 1000}};

DetectorOptions OptionsFor(const Case& floor, int threads = 1) {
  DetectorOptions options;
  const double focal = 0.75 * floor.width;
  options.camera = CameraModel{.width = floor.width,
                               .height = floor.height,
                               .fx = focal,
                               .fy = focal,
                               .cx = 0.5 * floor.width - 5,
                               .cy = 0.5 * floor.height + 5,
                               .kind = CameraModel::Kind::kBrownConrady,
                               .distortion = {-0.12, 0.03, 0.0005, -0.0003, 0}};
  options.families = {MarkerFamily{MarkerCode(MarkerSize{6, 6}, Variant::kSecded), kMarkerPx * kFloorM / focal, {}}};
  options.threads = threads;
  return options;
}

Image Draw(const Case& floor, PixelFormat format, std::uint64_t seed) {
  const DetectorOptions options = OptionsFor(floor);
  Scene scene;
  scene.background = {.kind = BackgroundKind::kNoise, .seed = seed};
  if (floor.markers > 0) {
    SwarmOptions swarm;
    swarm.camera = *options.camera;
    swarm.side_m = options.families[0].side_m;
    swarm.distance_m = kFloorM;
    swarm.margin_cells = 1;
    for (std::uint64_t id = 0; id < floor.markers; ++id)
      swarm.boards.push_back(MakeBoard(options.families[0].code, id));
    scene.markers = Swarm(swarm, seed).At(std::chrono::seconds(0));
  }
  RenderOptions render;
  render.camera = *options.camera;
  render.format = format;
  return Render(scene, render, seed);
}

using Milliseconds = std::chrono::duration<double, std::milli>;

/// The fastest of some runs, ms. @param found how many markers it finds.
double FastestMs(Detector& detector, const Image& image, int repetitions, std::size_t& found) {
  std::vector<MarkerPose> markers;
  Milliseconds fastest(1e9);
  for (int i = 0; i <= repetitions; ++i) {
    const auto start = std::chrono::steady_clock::now();
    detector.Detect(image.view(), markers);
    fastest = std::min(fastest, Milliseconds(std::chrono::steady_clock::now() - start));
  }
  found = markers.size();
  return fastest.count();
}

/// Frames a millisecond that so many detectors do, each on a thread and image of its own; the best of some rounds.
double Throughput(const std::vector<Image>& images, const Case& floor, std::size_t detectors, int repetitions) {
  constexpr int kFrames = 20;
  std::vector<Milliseconds> took(static_cast<std::size_t>(repetitions), Milliseconds(0));
  std::barrier round(static_cast<std::ptrdiff_t>(detectors));
  const auto work = [&](std::size_t index) {
    Detector detector(OptionsFor(floor));
    std::vector<MarkerPose> markers;
    detector.Detect(images[index].view(), markers);
    for (Milliseconds& slowest : took) {
      round.arrive_and_wait();
      const auto start = std::chrono::steady_clock::now();
      for (int i = 0; i < kFrames; ++i) detector.Detect(images[index].view(), markers);
      round.arrive_and_wait();
      if (index == 0) slowest = std::chrono::steady_clock::now() - start;
    }
  };
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < detectors; ++i) threads.emplace_back(work, i);
  for (std::thread& thread : threads) thread.join();
  return static_cast<double>(detectors) * kFrames / std::min_element(took.begin(), took.end())->count();
}

void ShowGrowth(PixelFormat format, std::uint64_t seed, int repetitions) {
  constexpr Eigen::Index kCount = std::size(kCases);
  Eigen::MatrixX2d design(kCount, 2);
  Eigen::VectorXd ms(kCount);
  fmt::print("{}\n", PixelFormatName(format));
  for (Eigen::Index i = 0; i < kCount; ++i) {
    const Case& floor = kCases[i];
    const Image image = Draw(floor, format, seed);
    Detector detector(OptionsFor(floor));
    std::size_t found = 0;
    ms(i) = FastestMs(detector, image, repetitions, found);
    design.row(i) << static_cast<double>(floor.width) * floor.height, static_cast<double>(floor.markers);
    fmt::print("  {:4} x {:4}  {:4} markers, {:4} found  {:7.3f} ms\n", floor.width, floor.height, floor.markers, found,
               ms(i));
  }
  // Each case weighs as much: what matters is by which factor it is off.
  const Eigen::VectorXd weights = ms.cwiseInverse();
  const Eigen::Vector2d law =
      (weights.asDiagonal() * design).colPivHouseholderQr().solve(Eigen::VectorXd(weights.cwiseProduct(ms)));
  const Eigen::VectorXd off = (design * law).cwiseQuotient(ms);
  fmt::print("  time = {:.2f} ns a pixel + {:.1f} us a marker; cases take {:.2f} to {:.2f} of that\n\n", 1e6 * law(0),
             1e3 * law(1), 1 / off.maxCoeff(), 1 / off.minCoeff());
}

void ShowThreads(std::uint64_t seed, int repetitions) {
  const Case floor{1920, 1080, 50};
  const std::vector<Image> images{Draw(floor, PixelFormat::kBgr8, seed), Draw(floor, PixelFormat::kBgr8, seed + 1)};
  fmt::print("two frames at once: {:.2f} times the frames of one\n",
             Throughput(images, floor, 2, repetitions) / Throughput(images, floor, 1, repetitions));
  std::size_t found = 0;
  Detector one(OptionsFor(floor)), two(OptionsFor(floor, 2));
  const double alone = FastestMs(one, images[0], 10 * repetitions, found);
  fmt::print("two threads on one frame: {:.2f} times as fast\n",
             alone / FastestMs(two, images[0], 10 * repetitions, found));
}

}  // namespace
}  // namespace chequer::bench

int main(int argc, char** argv) {
  std::uint64_t seed = 1;
  int repetitions = 10;
  CLI::App app("How the detector's time grows with pixels and markers, and what a second thread is worth.");
  app.add_option("--seed", seed, "of the scenes");
  app.add_option("--repeat", repetitions, "repetitions of each, the fastest counts")->check(CLI::Range(1, 1000));
  CLI11_PARSE(app, argc, argv);
  try {
    for (const auto format : {chequer::PixelFormat::kBgr8, chequer::PixelFormat::kBayerRg8})
      chequer::bench::ShowGrowth(format, seed, repetitions);
    chequer::bench::ShowThreads(seed, repetitions);
  } catch (const std::exception& error) {
    fmt::print(stderr, "growth: {}\n", error.what());
    return 1;
  }
}
