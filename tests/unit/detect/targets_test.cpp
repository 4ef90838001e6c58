// The same detections from every instruction set of this machine, down to the one that every machine has.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "chequer/detector.h"
#include "support/scenes.h"

namespace chequer {
namespace {

TEST(Targets, AllDetectTheSame) {
  test::KnownFrame frame = test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), 1111, 11, 2);
  DetectorOptions options;
  options.families[0].side_m = frame.scene.markers[0].side_m;
  options.camera = frame.options.camera;
  const Image image = frame.Draw();
  const std::vector<MarkerPose> expected = Detector(options).Detect(image.view());
  ASSERT_EQ(expected.size(), 1u);
  int tried = 0;
  for (auto left = static_cast<std::uint64_t>(hwy::SupportedTargets()); left != 0; left &= left - 1) {
    const auto target = static_cast<std::int64_t>(left & ~(left - 1));
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    const std::vector<MarkerPose> found = Detector(options).Detect(image.view());
    hwy::SetSupportedTargetsForTest(0);
    ++tried;
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].id, expected[0].id);
    // Sums in another order differ in their last digits.
    EXPECT_LT((found[0].camera_from_marker.translation - expected[0].camera_from_marker.translation).norm(), 2e-6);
  }
  EXPECT_GE(tried, 1);
}

}  // namespace
}  // namespace chequer
