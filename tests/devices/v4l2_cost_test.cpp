#include <gtest/gtest.h>

#include <cstdio>

#include "capture/v4l2_source.h"
#include "devices/camera_test_tools.h"
#include "support/fake_v4l2.h"

namespace chequer {
namespace {

// What a frame costs beyond the driver's own work, on this host's processor: the fake driver takes no time.
TEST(V4l2Cost, CapturingAndHandingOverTakeLittle) {
  const test::FakeV4l2 driver;
  V4l2Options options;
  options.camera.device = "Fake";
  options.camera.fps = 60;
  V4l2Source source(options, driver.Roots());
  ASSERT_EQ(source.Open(), "");
  const test::CaptureCost cost = test::MeasureCapture(source, 2000);
  EXPECT_EQ(cost.problem, "");
  std::printf("1920x1080: %.4f ms of processor a frame, handed over in %.4f ms\n", cost.cpu_ms, cost.hand_over_ms);
  EXPECT_LT(cost.cpu_ms, 0.3);
  EXPECT_LT(cost.cpu_ms + cost.hand_over_ms, 0.3);
  EXPECT_LE(cost.places, options.camera.buffers);  // nothing is copied
}

}  // namespace
}  // namespace chequer
