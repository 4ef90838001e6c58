#include "support/scenes.h"

#include <gtest/gtest.h>

#include <set>

namespace chequer::test {
namespace {

TEST(OneMarker, HasTheCellsAskedFor) {
  const MarkerCode code(MarkerSize{8, 8}, Variant::kGolay);
  const KnownFrame frame = OneMarker(code, 100, 7, 3, 0);
  const auto truth = frame.Truth();
  ASSERT_EQ(truth.size(), 1u);
  EXPECT_EQ(truth[0].id, 100u);
  EXPECT_NEAR(truth[0].cell_px, 7, 0.01);
  EXPECT_EQ(frame.Draw().width(), 640);
}

TEST(InnerCorners, RunRowByRowFromTheTopLeft) {
  const CameraModel camera = PlainCamera(640, 480, 600);
  const MarkerCode code(MarkerSize{6, 6}, Variant::kSecded);
  const auto corners = InnerCorners(MarkerOf(code, 1, FacingPose({0, 0, 1}, 0)), camera);
  ASSERT_EQ(corners.size(), 25u);
  // Cells of 12 px about (319.5, 239.5).
  EXPECT_LT((corners[0] - Eigen::Vector2d(295.5, 215.5)).norm(), 1e-9);
  EXPECT_LT((corners[1] - Eigen::Vector2d(307.5, 215.5)).norm(), 1e-9);
  EXPECT_LT((corners[24] - Eigen::Vector2d(343.5, 263.5)).norm(), 1e-9);
}

TEST(ClutterFrames, AreManyKindsWithoutMarkers) {
  std::set<std::string> names;
  for (const KnownFrame& frame : ClutterFrames(14, 5, 160, 120)) {
    EXPECT_TRUE(frame.scene.markers.empty());
    EXPECT_EQ(frame.options.Check(), "");
    EXPECT_EQ(frame.Draw().height(), 120);
    names.insert(frame.name);
  }
  EXPECT_EQ(names.size(), 14u);
}

}  // namespace
}  // namespace chequer::test
