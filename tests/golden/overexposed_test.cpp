// Boards whose light cells are overexposed in all channels, as when lamps go on before the camera has adapted.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "chequer/detector.h"
#include "support/stream_frames.h"

namespace chequer {
namespace {

constexpr const char* kLampsGoOn = R"(
seed = 5
[camera]
size = "1280x720"
focal_px = 1800
distance = 3.0
fps = 60
exposure_ms = 3
[swarm]
robots = 16
size = "6x6"
variant = "secded"
side = 0.1
speed = 0.4
[[phase]]
kind = "calm"
frames = 1
[[phase]]
kind = "bright"
light = 6.0
frames = 4
)";

/// What is white must not seem yellow, nor sharp edges blurred, for want of what lies above full scale.
TEST(Overexposed, BoardsKeepTheirIdsAndCostLittle) {
  const test::StreamFrames frames(kLampsGoOn);
  Detector detector(frames.Options());
  std::vector<MarkerPose> markers;
  std::uint64_t calm = 0, most = 0;
  test::StreamScore score;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const test::StreamFrame frame = frames.Frame(i);
    detector.Detect(frame.image.view(), markers);
    if (i == 0) {
      calm = detector.stats().work;
      continue;
    }
    most = std::max(most, detector.stats().work);
    score += test::ScoreFrame(markers, frame.truth);
  }
  EXPECT_EQ(score.wrong + score.twice, 0);
  EXPECT_GE(score.Recall(), 0.95);
  EXPECT_LE(most, 15 * calm);
}

}  // namespace
}  // namespace chequer
