#include "tools/plan_estimate.h"

#include <gtest/gtest.h>

#include "tools/marker_options.h"

namespace chequer {
namespace {

/// 12 mm of lens on pixels of 3.45 um.
PlanScene Planned(double side_m, double distance_m) {
  PlanScene scene;
  scene.view.camera = {.width = 1920, .height = 1080, .fx = 3478.3, .fy = 3478.3, .cx = 959.5, .cy = 539.5};
  scene.side_m = side_m;
  scene.distance_m = distance_m;
  scene.trials = 12;
  return scene;
}

TEST(PlanEstimate, LargeCellsAreReadAboutAsExactlyAsTheBoundAllows) {
  const PlanEstimate estimate = EstimatePlan(Planned(0.04, 3));
  EXPECT_NEAR(estimate.cell_px, 7.73, 0.01);
  EXPECT_EQ(estimate.Verdict(), PlanVerdict::kRead);
  EXPECT_EQ(estimate.wrong, 0);
  EXPECT_NEAR(estimate.seen_m.x(), 1920 / 3478.3 * 3, 0.01);
  EXPECT_NEAR(estimate.seen_m.y(), 1080 / 3478.3 * 3, 0.01);
  // Twelve markers are few: their errors are within a factor of what is expected of them.
  EXPECT_GT(estimate.error_m.z(), 0.4 * estimate.bound_m.z());
  EXPECT_LT(estimate.error_m.z(), 3 * estimate.bound_m.z());
  EXPECT_LT(estimate.error_m.head<2>().norm(), 3 * estimate.bound_m.head<2>().norm());
}

TEST(PlanEstimate, SmallestSideWouldDoAndLessWouldNot) {
  const double side_m = EstimatePlan(Planned(0.04, 3)).smallest_side_m;
  EXPECT_NEAR(side_m, kSafeCellPx * 6 * 3 / 3478.3, 1e-6);
  EXPECT_EQ(EstimatePlan(Planned(side_m * 1.001, 3)).Verdict(), PlanVerdict::kRead);
  EXPECT_EQ(EstimatePlan(Planned(side_m * 0.95, 3)).Verdict(), PlanVerdict::kDoubtful);
  EXPECT_EQ(EstimatePlan(Planned(side_m * 0.5, 3)).Verdict(), PlanVerdict::kNotRead);
}

TEST(PlanEstimate, FarthestIsWhereTheCellsAreJustSafe) {
  const double distance_m = EstimatePlan(Planned(0.04, 3)).farthest_m;
  EXPECT_NEAR(EstimatePlan(Planned(0.04, distance_m)).cell_px, kSafeCellPx, 1e-9);
}

TEST(PlanEstimate, AMarkerLargerThanTheImageIsNotRead) {
  const PlanEstimate estimate = EstimatePlan(Planned(1, 3));
  EXPECT_FALSE(estimate.fits);
  EXPECT_EQ(estimate.Verdict(), PlanVerdict::kNotRead);
}

TEST(PlanEstimate, LargerImagesSeeMoreThroughABentLensToo) {
  PlanScene scene = Planned(0.04, 3);
  const double straight = EstimatePlan(scene).seen_m.x();
  scene.view.camera.kind = CameraModel::Kind::kBrownConrady;
  scene.view.camera.distortion = {-0.2, 0, 0, 0, 0};
  const PlanEstimate bent = EstimatePlan(scene);
  EXPECT_GT(bent.seen_m.x(), straight);
  EXPECT_EQ(bent.Verdict(), PlanVerdict::kRead);
}

}  // namespace
}  // namespace chequer
