#include "bench/reels.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <thread>

#include "simulate/random.h"
#include "simulate/stream.h"

namespace chequer::bench {
namespace {

std::vector<Scenario> LoadAll(const ReelRequest& request) {
  std::vector<Scenario> scenarios;
  for (const std::filesystem::path& path : request.scenarios) scenarios.push_back(LoadScenario(path));
  if (scenarios.empty()) throw std::runtime_error("there is no scenario to play");
  return scenarios;
}

/// One camera and one kind of marker for all.
void Unify(std::vector<Scenario>& scenarios, const ReelRequest& request) {
  CameraModel camera = scenarios.front().camera.render.camera;
  if (request.size) {
    const auto [width, height] = *request.size;
    camera.cx += 0.5 * (width - camera.width);
    camera.cy += 0.5 * (height - camera.height);
    camera.width = width;
    camera.height = height;
  }
  const double distance_m = scenarios.front().camera.distance_m;
  const ScenarioSwarm& markers = scenarios.front().swarm;
  for (Scenario& scenario : scenarios) {
    const CameraModel& own = scenario.camera.render.camera;
    const double area = std::pow(distance_m / camera.fx, 2) * camera.width * camera.height,
                 own_area = std::pow(scenario.camera.distance_m / own.fx, 2) * own.width * own.height;
    scenario.swarm.robots = request.robots.value_or(
        std::max(1, static_cast<int>(std::lround(scenario.swarm.robots * std::min(1.0, area / own_area)))));
    scenario.swarm.size = markers.size;
    scenario.swarm.variant = markers.variant;
    scenario.swarm.side_m = markers.side_m;
    scenario.camera.render.camera = camera;
    scenario.camera.render.format = PixelFormat::kBayerRg8;
    scenario.camera.render.tone_curve = scenarios.front().camera.render.tone_curve;
    scenario.camera.distance_m = distance_m;
  }
}

int CountFrames(const std::vector<Scenario>& scenarios) {
  int frames = 0;
  for (const Scenario& scenario : scenarios) frames += scenario.FrameCount();
  return frames;
}

/// Shortens phases. Three frames are left of each, so that something can happen.
void Shorten(std::vector<Scenario>& scenarios, double share) {
  constexpr int kLeastFrames = 3;
  for (Scenario& scenario : scenarios)
    for (Phase& phase : scenario.phases)
      phase.frames =
          std::min(phase.frames, std::max(kLeastFrames, static_cast<int>(std::lround(phase.frames * share))));
}

void RenderReel(Reel& reel) {
  const Stream stream(reel.scenario);
  for (std::size_t i = 0; i < stream.size(); ++i) {
    reel.frames.push_back(MakeCleanFrame(stream.Light(i), stream.CameraOf(i)));
    reel.truth.push_back(stream.Truth(i));
  }
}

}  // namespace

std::vector<Reel> PlanReels(const ReelRequest& request) {
  std::vector<Scenario> scenarios = LoadAll(request);
  Unify(scenarios, request);
  const int of_a_seed = CountFrames(scenarios);
  const int seeds = (request.frames + of_a_seed - 1) / of_a_seed;
  Shorten(scenarios, static_cast<double>(request.frames) / (static_cast<double>(of_a_seed) * seeds));
  std::vector<Reel> reels;
  for (int i = 0; i < seeds; ++i)
    for (std::size_t k = 0; k < scenarios.size(); ++k) {
      Reel reel{.stream = request.scenarios[k].stem(), .scenario = scenarios[k], .frames = {}, .truth = {}};
      reel.scenario.seed = request.seed + static_cast<std::uint64_t>(i);
      reel.scenario.camera.background.seed = reel.scenario.seed;
      reels.push_back(std::move(reel));
    }
  return reels;
}

void RenderReels(std::vector<Reel>& reels, int jobs) {
  std::atomic<std::size_t> next = 0;
  std::vector<std::exception_ptr> failures(reels.size());
  const auto render = [&] {
    for (std::size_t i = next++; i < reels.size(); i = next++) {
      try {
        RenderReel(reels[i]);
      } catch (...) {
        failures[i] = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    for (int i = 1; i < jobs; ++i) threads.emplace_back(render);
    render();
  }
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

DetectorOptions OptionsFor(const std::vector<Reel>& reels) {
  const ScenarioSwarm& swarm = reels.front().scenario.swarm;
  DetectorOptions options;
  options.families = {{.code = MarkerCode(swarm.size, swarm.variant), .side_m = swarm.side_m, .roster = {}}};
  options.camera = reels.front().scenario.camera.render.camera;
  return options;
}

std::uint64_t NoiseSeed(const Reel& reel, std::size_t frame, std::uint64_t round) {
  return DeriveSeed(DeriveSeed(reel.seed(), 1 + frame), round);
}

}  // namespace chequer::bench
