#include "simulate/stress.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "simulate/truth.h"

namespace chequer {
namespace {

TEST(StressCases, EachShowsOneWholeMarkerAndCanBeRendered) {
  const MarkerCode code(MarkerSize{}, Variant::kSecded);
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    std::set<std::string> tags;
    for (const StressCase& stress : StressCases(code, seed)) {
      EXPECT_TRUE(tags.insert(stress.tag).second) << stress.tag << " twice";
      EXPECT_EQ(stress.options.Check(), "") << stress.tag;
      EXPECT_EQ(stress.scene.Check(), "") << stress.tag;
      EXPECT_EQ(TruthOf(stress.scene.markers, stress.options.camera).size(), 1u) << stress.tag << " seed " << seed;
    }
    EXPECT_GT(tags.size(), 40u);
  }
}

const StressCase& Find(const std::vector<StressCase>& cases, const std::string& tag) {
  return *std::find_if(cases.begin(), cases.end(), [&](const StressCase& stress) { return stress.tag == tag; });
}

TEST(StressCases, AmountsAreWhatTheTagsSay) {
  const auto cases = StressCases(MarkerCode(MarkerSize{}, Variant::kSecded), 1);
  EXPECT_DOUBLE_EQ(Find(cases, "exposure=0.06").options.sensor.exposure, 0.06);
  EXPECT_DOUBLE_EQ(Find(cases, "psf_px=2").options.blur_sigma_px, 2);
  EXPECT_EQ(Find(cases, "occluded=0.2").scene.markers[0].occluders.size(), 1u);
  const StressCase& small = Find(cases, "side_px=36");
  EXPECT_NEAR(SmallestCellPx(small.scene.markers[0], small.options.camera), 6, 0.3);
  const RigidTransform& tilted = Find(cases, "tilt_deg=65").scene.markers[0].camera_from_marker;
  EXPECT_NEAR(std::acos(-(tilted.rotation * Eigen::Vector3d::UnitZ()).z()) * 180 / M_PI, 65, 1e-9);
}

}  // namespace
}  // namespace chequer
