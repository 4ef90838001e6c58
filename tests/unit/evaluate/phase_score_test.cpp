#include "evaluate/phase_score.h"

#include <gtest/gtest.h>

#include <cmath>

namespace chequer {
namespace {

ScoredFrame FrameOf(const std::string& phase, int expected, int read, double detect_ms) {
  FrameScore score;
  score.expected = expected;
  score.read = read;
  score.errors.push_back({.position_mm = detect_ms, .angle_deg = 1});
  return {.phase = phase, .time_s = 0, .score = score, .detect_ms = detect_ms, .latency_ms = {}};
}

ScoredFrame Missing(const std::string& phase) {
  return {.phase = phase, .time_s = 0, .score = {}, .detect_ms = {}, .latency_ms = {}};
}

TEST(PhaseScore, SumsUpEachPhaseAndAll) {
  const std::vector<ScoredFrame> frames{FrameOf("calm", 4, 4, 1), FrameOf("knock", 4, 1, 5), Missing("knock"),
                                        FrameOf("knock", 4, 3, 7), FrameOf("calm", 4, 4, 3)};
  const auto phases = ScorePhases(frames);
  ASSERT_EQ(phases.size(), 2u);
  EXPECT_EQ(phases[0].name, "calm");
  EXPECT_EQ(phases[0].frames, 2);
  EXPECT_EQ(phases[0].total.Recall(), 1);
  EXPECT_EQ(phases[1].frames, 3);
  EXPECT_EQ(phases[1].missing, 1);
  EXPECT_EQ(phases[1].total.expected, 8) << "a frame of which nothing came counts as missing and nowhere else";
  EXPECT_EQ(phases[1].total.Recall(), 0.5);
  EXPECT_EQ(phases[1].detect_ms.median, 6);
  EXPECT_EQ(phases[1].detect_ms.largest, 7);
  EXPECT_EQ(phases[1].latency_ms.count, 0u);
  const PhaseScore all = ScoreAll(frames, "all");
  EXPECT_EQ(all.frames, 5);
  EXPECT_EQ(all.total.read, 12);
  EXPECT_NEAR(all.position_mm.rms, std::sqrt((1 + 25 + 49 + 9) / 4.0), 1e-12);
}

TEST(SpreadOf, NamesTheNumbers) {
  std::vector<double> values;
  for (int i = 200; i >= 1; --i) values.push_back(i);
  const Spread spread = SpreadOf(values);
  EXPECT_EQ(spread.count, 200u);
  EXPECT_EQ(spread.median, 100.5);
  EXPECT_EQ(spread.p99, 198);
  EXPECT_EQ(spread.largest, 200);
  EXPECT_EQ(spread.mean, 100.5);
  EXPECT_EQ(SpreadOf({3}).p99, 3);
  EXPECT_EQ(SpreadOf({}).count, 0u);
}

}  // namespace
}  // namespace chequer
