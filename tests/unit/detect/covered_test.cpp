// Boards of which something covers a side.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "support/pose_errors.h"
#include "support/stream_frames.h"

namespace chequer {
namespace {

/// Eight robots, a hand over a fifth to a third of each: its edge lies across cells.
std::string Covered(std::uint64_t seed) {
  return "seed = " + std::to_string(seed) + R"(
[camera]
size = "800x450"
focal_px = 1800
distance = 3.0
fps = 60
exposure_ms = 6.67
[swarm]
robots = 8
side = 0.1
speed = 0.4
[[phase]]
kind = "calm"
frames = 2
[[phase]]
kind = "hands"
share = 1.0
occluded = [0.2, 0.3]
frames = 8
)";
}

TEST(CoveredBoards, HavePosesThatAreHonestAndTheSameWithAMemory) {
  test::PoseErrors errors, differences;
  for (const std::uint64_t seed : {2u, 3u}) {
    const test::StreamFrames stream{Covered(seed)};
    Detector cold(stream.Options()), follower(stream.Options());
    DetectorMemory memory;
    std::vector<MarkerPose> warm;
    for (std::size_t i = 0; i < stream.size(); ++i) {
      const test::StreamFrame frame = stream.Frame(i);
      follower.Detect(frame.image.view(), std::chrono::milliseconds(1000 + 17 * i), memory, warm);
      const std::vector<MarkerPose> found = cold.Detect(frame.image.view());
      differences.AddDifferences(found, warm);
      errors.AddDifferences(found, frame.truth.markers);
    }
  }
  // Cells that are covered in part told a shading that is none, and took the corners beside them along: squared errors
  // were 3, and poses differed by 1.4 standard deviations.
  RecordProperty("position", std::to_string(errors.position()));
  EXPECT_GT(differences.poses(), 90);
  EXPECT_LT(errors.position(), 1.4);
  EXPECT_LT(errors.orientation(), 1.4);
  EXPECT_LT(std::sqrt(differences.position()), 0.25);
}

}  // namespace
}  // namespace chequer
