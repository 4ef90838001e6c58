// The same detections from every instruction set of this machine, down to scalar code, which every machine has.
#include "support/targets.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "chequer/detector.h"
#include "support/scenes.h"

namespace chequer {
namespace {

constexpr double kSteepRad = 1.34;

/// A frame, and what makes it another.
struct TargetCase {
  const char* name;
  PixelFormat format = PixelFormat::kBgr8;
  double cell_px = 11;
  double tilt_rad = 0.15;
};

class Targets : public testing::TestWithParam<TargetCase> {};

/// Runs a detector as a machine with that instruction set would.
std::vector<MarkerPose> DetectOn(std::int64_t target, const DetectorOptions& options, const ImageView& image) {
  hwy::SetSupportedTargetsForTest(target);
  std::vector<MarkerPose> found = Detector(options).Detect(image);
  hwy::SetSupportedTargetsForTest(0);
  return found;
}

TEST_P(Targets, AllDetectTheSame) {
  const TargetCase& kind = GetParam();
  test::KnownFrame frame = test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), 1111, kind.cell_px, 2, kind.tilt_rad);
  frame.options.format = kind.format;
  frame.scene.background = {.kind = BackgroundKind::kWood, .seed = 3};
  DetectorOptions options;
  options.families[0].side_m = frame.scene.markers[0].side_m;
  options.camera = frame.options.camera;
  const Image image = frame.Draw();
  const std::vector<MarkerPose> expected = Detector(options).Detect(image.view());
  ASSERT_EQ(expected.size(), 1u);
  bool scalar = false;
  for (const std::int64_t target : test::AllTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    const std::vector<MarkerPose> found = DetectOn(target, options, image.view());
    scalar |= target == HWY_SCALAR || target == HWY_EMU128;
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].id, expected[0].id);
    EXPECT_EQ(found[0].warnings, expected[0].warnings);
    EXPECT_EQ(found[0].corners_used, expected[0].corners_used);
    // Sums in another order differ in their last digits: by a thousandth of what noise moves the smallest boards.
    EXPECT_LT((found[0].camera_from_marker.translation - expected[0].camera_from_marker.translation).norm(), 2e-6);
    EXPECT_LT(found[0].camera_from_marker.rotation.angularDistance(expected[0].camera_from_marker.rotation), 1e-5);
  }
  EXPECT_TRUE(scalar) << "not tried";
}

INSTANTIATE_TEST_SUITE_P(Frames, Targets,
                         testing::Values(TargetCase{"bgr"}, TargetCase{"bayer", PixelFormat::kBayerRg8},
                                         TargetCase{"yuyv", PixelFormat::kYuyv},
                                         TargetCase{"small_cells", PixelFormat::kBgr8, 4.5},
                                         TargetCase{"large_cells", PixelFormat::kBgr8, 40},
                                         TargetCase{"second_look", PixelFormat::kBgr8, 15, kSteepRad}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace chequer
