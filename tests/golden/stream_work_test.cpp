// What hard phases of a stream cost over its calm frames, counted in units of work, and that they are read for it.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "chequer/detector.h"
#include "chequer/detector_memory.h"
#include "support/stream_frames.h"

namespace chequer {
namespace {

/// Sixteen robots with boards of 10 px cells, and these phases. The first is called calm.
std::string RobotsIn(const std::string& seed_and_phases) {
  return seed_and_phases + R"(
[camera]
size = "1280x720"
focal_px = 1800
distance = 3.0
fps = 60
exposure_ms = 6.67
[swarm]
robots = 16
size = "6x6"
variant = "secded"
side = 0.1
speed = 0.4
)";
}

/// The same in calm, then seen by a camera that is knocked.
std::string RobotsInAKnock(int seed, int calm_frames, int knock_frames) {
  return RobotsIn("seed = " + std::to_string(seed) +
                  "\n[[phase]]\nkind = \"calm\"\nframes = " + std::to_string(calm_frames) +
                  "\n[[phase]]\nkind = \"knock\"\nmax_px = 14\nframes = " + std::to_string(knock_frames) + "\n");
}

struct Costs {
  std::vector<std::uint64_t> calm, hard;  ///< of frames, sorted, units
  test::StreamScore hard_score;

  std::uint64_t CalmMedian() const { return calm[calm.size() / 2]; }
};

/// One detector over the whole stream. @param budget 0: none. @param remembers whether it has a memory.
Costs CostsOf(const std::string& scenario, std::uint64_t budget = 0, bool remembers = false) {
  const test::StreamFrames frames(scenario);
  DetectorOptions options = frames.Options();
  options.budget = budget;
  Detector detector(options);
  DetectorMemory memory;
  std::vector<MarkerPose> markers;
  Costs costs;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const test::StreamFrame frame = frames.Frame(i);
    if (remembers)
      detector.Detect(frame.image.view(), std::chrono::nanoseconds(std::llround(1e9 * frame.truth.time_s.value())),
                      memory, markers);
    else
      detector.Detect(frame.image.view(), markers);
    const bool calm = frames.phase(i) == "calm";
    (calm ? costs.calm : costs.hard).push_back(detector.stats().work);
    if (!calm) costs.hard_score += test::ScoreFrame(markers, frame.truth);
  }
  std::sort(costs.calm.begin(), costs.calm.end());
  std::sort(costs.hard.begin(), costs.hard.end());
  return costs;
}

// What one board has shown of how all of them moved starts the others.
TEST(Knock, CostsTenCalmFramesWithoutABudget) {
  const Costs costs = CostsOf(RobotsInAKnock(11, 3, 12));
  EXPECT_LE(costs.hard[costs.hard.size() / 2], 10 * costs.CalmMedian());
  EXPECT_LE(costs.hard.back(), 20 * costs.CalmMedian());
  EXPECT_GE(costs.hard_score.Recall(), 0.79);
  EXPECT_EQ(costs.hard_score.wrong + costs.hard_score.twice, 0);
}

// As chequerd sees them: with a memory, and a budget that lasts. Three boards tell the motion of all, and none is
// fitted plainly in vain.
TEST(Knock, CostsFiveCalmFramesWithAMemory) {
  for (const std::uint64_t budget : {std::uint64_t{0}, std::uint64_t{1'000'000}}) {
    const Costs costs = CostsOf(RobotsInAKnock(21, 8, 16), budget, true);
    EXPECT_LE(costs.hard[costs.hard.size() / 2], 5 * costs.CalmMedian()) << "budget " << budget;
    EXPECT_LE(costs.hard.back(), 8 * costs.CalmMedian()) << "budget " << budget;
    EXPECT_GE(costs.hard_score.Recall(), 0.99) << "budget " << budget;
    EXPECT_EQ(costs.hard_score.wrong + costs.hard_score.twice, 0) << "budget " << budget;
  }
}

// Lamps go on before the camera has adapted. What is white must not seem yellow, nor sharp edges blurred, for want of
// what lies above full scale.
TEST(Overexposed, BoardsKeepTheirIdsAndCostLittle) {
  const Costs costs = CostsOf(RobotsIn(R"(
seed = 5
[[phase]]
kind = "calm"
frames = 1
[[phase]]
kind = "bright"
light = 6.0
frames = 4
)"));
  EXPECT_EQ(costs.hard_score.wrong + costs.hard_score.twice, 0);
  EXPECT_GE(costs.hard_score.Recall(), 0.95);
  EXPECT_LE(costs.hard.back(), 15 * costs.CalmMedian());
}

}  // namespace
}  // namespace chequer
