#include "bench/reels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "evaluate/frame_score.h"

namespace chequer::bench {
namespace {

ReelRequest SmallRequest() {
  ReelRequest request;
  for (const char* name : {"reference", "traffic"})
    request.scenarios.push_back(std::filesystem::path(CHEQUER_SCENARIOS) / (std::string(name) + ".toml"));
  request.size = {320, 240};
  request.frames = 30;
  return request;
}

TEST(Reels, HaveOneCameraAndAllKindsOfPhases) {
  const std::vector<Reel> reels = PlanReels(SmallRequest());
  ASSERT_EQ(reels.size(), 2u);
  std::set<PhaseKind> kinds;
  for (const Reel& reel : reels) {
    EXPECT_EQ(reel.scenario.camera.render.camera.fx, 1800);
    EXPECT_EQ(reel.scenario.camera.distance_m, 3);
    EXPECT_EQ(reel.scenario.camera.render.camera.width, 320);
    EXPECT_NEAR(reel.scenario.camera.render.camera.cx, 159.5, 1e-9);
    EXPECT_EQ(reel.scenario.swarm.robots, 1) << "a twelfth of the floor";
    for (const Phase& phase : reel.scenario.phases) {
      EXPECT_GE(phase.frames, 3);
      EXPECT_LE(phase.frames, 8);
      kinds.insert(phase.kind);
    }
  }
  EXPECT_THAT(kinds, testing::UnorderedElementsAre(PhaseKind::kCalm, PhaseKind::kDark, PhaseKind::kKnock,
                                                   PhaseKind::kFast, PhaseKind::kHands, PhaseKind::kBright,
                                                   PhaseKind::kTraffic, PhaseKind::kTurn));
}

TEST(Reels, TakeAsManySeedsAsTheFramesNeed) {
  ReelRequest request = SmallRequest();
  request.seed = 7;
  request.frames = 1500;
  const std::vector<Reel> reels = PlanReels(request);
  ASSERT_EQ(reels.size(), 6u);
  std::set<std::uint64_t> seeds;
  int frames = 0;
  for (const Reel& reel : reels) {
    seeds.insert(reel.seed());
    frames += reel.scenario.FrameCount();
  }
  EXPECT_THAT(seeds, testing::ElementsAre(7, 8, 9));
  EXPECT_NEAR(frames, 1500, 20);
}

TEST(Reels, AreReadByTheDetector) {
  ReelRequest request = SmallRequest();
  request.scenarios.resize(1);
  std::vector<Reel> reels = PlanReels(request);
  RenderReels(reels, 2);
  const Reel& reel = reels.front();
  ASSERT_EQ(reel.frames.size(), reel.truth.size());
  Detector detector(OptionsFor(reels));
  FreshNoise noise(ToneCurve::Srgb());
  FrameScore score;
  for (std::size_t i = 0; i < reel.frames.size(); ++i) {
    if (!reel.truth[i].phase.starts_with("calm")) continue;
    Image image;
    noise.Expose(reel.frames[i], NoiseSeed(reel, i, 5), image);
    FoundFrame found;
    for (const MarkerPose& pose : detector.Detect(image.view()))
      found.markers.push_back({.id = pose.id,
                               .variant = std::string(VariantName(pose.variant)),
                               .center_px = pose.center_px,
                               .camera_from_marker = pose.camera_from_marker,
                               .covariance = pose.covariance});
    score += ScoreFrame(found, reel.truth[i]);
  }
  EXPECT_GE(score.expected, 9);
  EXPECT_EQ(score.read, score.expected);
  EXPECT_EQ(score.wrong + score.twice + score.ghosts, 0);
  for (const PoseError& error : score.errors) EXPECT_LT(*error.position_over_covariance, 6);
}

}  // namespace
}  // namespace chequer::bench
