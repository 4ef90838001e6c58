// What a knock of the camera costs, counted in units of work: what one board has shown of how all of them moved starts
// the others.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "chequer/detector.h"
#include "support/stream_frames.h"

namespace chequer {
namespace {

constexpr const char* kKnock = R"(
seed = 11
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
[[phase]]
kind = "calm"
frames = 3
[[phase]]
kind = "knock"
max_px = 14
frames = 12
)";

std::uint64_t Median(std::vector<std::uint64_t> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

TEST(Knock, CostsTenCalmFramesWithoutABudget) {
  const test::StreamFrames frames(kKnock);
  Detector detector(frames.Options());
  std::vector<MarkerPose> markers;
  std::vector<std::uint64_t> calm, knock;
  test::StreamScore score;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const test::StreamFrame frame = frames.Frame(i);
    detector.Detect(frame.image.view(), markers);
    (frames.phase(i) == "calm" ? calm : knock).push_back(detector.stats().work);
    score += test::ScoreFrame(markers, frame.truth);
  }
  EXPECT_LE(Median(knock), 10 * Median(calm));
  EXPECT_LE(*std::max_element(knock.begin(), knock.end()), 20 * Median(calm));
  EXPECT_GE(score.Recall(), 0.79) << "so much is read for it";
  EXPECT_EQ(score.wrong + score.twice, 0);
}

}  // namespace
}  // namespace chequer
