#include "detect/grids/edge_probes.h"

#include <gtest/gtest.h>

#include <vector>

namespace chequer {
namespace {

constexpr float kDark = 60, kLight = 160;

/// Light from row 20 on where that is below, else up to row 19.
BytePlane HalfLight(bool light_below) {
  BytePlane plane;
  plane.Resize(64, 40);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 64; ++x) plane.row(y)[x] = (y >= 20) == light_below ? 160 : 60;
  return plane;
}

EdgeProbes::Probe Along(Eigen::Vector2f from, Eigen::Vector2f to, bool light_on_left) {
  return {.from = from,
          .along = to - from,
          .light_on_left = light_on_left,
          .most_reach = 3,
          .least_step = 0.2f * (kLight - kDark)};
}

std::vector<int> Look(const BytePlane& plane, const std::vector<EdgeProbes::Probe>& probes) {
  EdgeProbes edges;
  edges.Start(probes.size());
  for (const EdgeProbes::Probe& probe : probes) edges.Add(probe);
  const auto found = edges.Look(plane);
  return {found.begin(), found.end()};
}

TEST(EdgeProbes, FindTheEdgeWithLightOnItsSideAlone) {
  const Eigen::Vector2f a(10, 19.5f), b(20, 19.5f);
  const BytePlane below = HalfLight(true), above = HalfLight(false);
  const std::vector<EdgeProbes::Probe> probes{Along(a, b, true), Along(a, b, false), Along(b, a, true),
                                              Along(b, a, false)};
  EXPECT_EQ(Look(below, probes), (std::vector{1, 0, 0, 1}));
  EXPECT_EQ(Look(above, probes), (std::vector{0, 1, 1, 0}));
}

TEST(EdgeProbes, AskForItAllAlong) {
  BytePlane plane = HalfLight(true);
  // Nothing to be seen where the last of the three places lies.
  for (int y = 0; y < 40; ++y)
    for (int x = 15; x < 64; ++x) plane.row(y)[x] = 100;
  EXPECT_EQ(Look(plane, {Along({2, 19.5f}, {12, 19.5f}, true), Along({8, 19.5f}, {18, 19.5f}, true)}),
            (std::vector{1, 0}));
}

TEST(EdgeProbes, LookNoFartherThanAQuarterOfTheLine) {
  BytePlane plane = HalfLight(true);
  for (int x = 0; x < 64; ++x) plane.row(19)[x] = plane.row(20)[x] = 110;
  // Short lines see no more than the grey between the two halves.
  EXPECT_EQ(Look(plane, {Along({10, 19.5f}, {12, 19.5f}, true), Along({10, 19.5f}, {20, 19.5f}, true)}),
            (std::vector{0, 1}));
}

TEST(EdgeProbes, TakeThePlanesEdgeForWhatLiesOutside) {
  const BytePlane plane = HalfLight(true);
  EXPECT_EQ(Look(plane, {Along({-8, 19.5f}, {2, 19.5f}, true), Along({60, 19.5f}, {90, 19.5f}, true),
                         Along({10, 60}, {20, 60}, true), Along({10, -9}, {20, -9}, true)}),
            (std::vector{1, 1, 0, 0}));
}

TEST(EdgeProbes, TellAsManyAsThereAre) {
  const BytePlane plane = HalfLight(true);
  std::vector<EdgeProbes::Probe> probes;
  std::vector<int> expected;
  for (int k = 0; k < 37; ++k) {
    probes.push_back(Along({10, 19.5f}, {20, 19.5f}, k % 3 == 0));
    expected.push_back(k % 3 == 0);
    EXPECT_EQ(Look(plane, probes), expected) << k + 1 << " probes";
  }
  EXPECT_TRUE(Look(plane, {}).empty());
}

TEST(EdgeProbes, FindNoEdgeInALineWithoutLength) {
  const BytePlane plane = HalfLight(true);
  EXPECT_EQ(Look(plane, {Along({10, 19.5f}, {10, 19.5f}, true)}), (std::vector{0}));
}

}  // namespace
}  // namespace chequer
