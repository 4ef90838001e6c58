#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/fresh_noise.h"
#include "chequer/detector.h"
#include "simulate/scenario.h"
#include "simulate/truth.h"

namespace chequer::bench {

/// Which streams a run plays.
struct ReelRequest {
  std::vector<std::filesystem::path> scenarios;
  std::uint64_t seed = 1;  ///< of the first; others follow where there are more frames than one seed gives
  int frames = 1350;       ///< rendered in all, about
  /// Pixels; without it the first scenario's. The focal length stays, so boards are as large and fewer.
  std::optional<std::pair<int, int>> size;
  std::optional<int> robots;  ///< in each; without it as many as the scenario has on the same area of floor
  int jobs = 1;               ///< threads that render
};

/// A scenario of one seed, rendered and kept.
struct Reel {
  std::string stream;  ///< the scenario's name
  Scenario scenario;   ///< as it was rendered
  std::vector<CleanFrame> frames;
  std::vector<FrameTruth> truth;

  std::uint64_t seed() const { return scenario.seed; }
};

/// The scenarios of a request, each as often as it has seeds, before they are rendered. All are filmed by the camera of
/// the first, from its distance, as a detector has one camera; in raw frames. Phases are shortened where fewer frames
/// are asked for than all have. Throws std::runtime_error naming the file and what is wrong.
std::vector<Reel> PlanReels(const ReelRequest& request);

/// Renders all frames. Throws std::runtime_error where robots find no room.
void RenderReels(std::vector<Reel>& reels, int jobs);

/// What a detector needs to read the markers of all of them. @pre there is one.
DetectorOptions OptionsFor(const std::vector<Reel>& reels);

/// Seed of a frame's noise.
std::uint64_t NoiseSeed(const Reel& reel, std::size_t frame, std::uint64_t round);

}  // namespace chequer::bench
