#include <gtest/gtest.h>

#include "capture/v4l2_source.h"
#include "devices/camera_test_tools.h"
#include "support/fake_v4l2.h"

namespace chequer {
namespace {

// How long that takes is for tests/bench/capture_cost: a test that is timed fails where the machine has else to do.
TEST(V4l2HandOver, FramesStayInTheDriversBuffers) {
  const test::FakeV4l2 driver;
  V4l2Options options;
  options.camera.device = "Fake";
  options.camera.fps = 60;
  V4l2Source source(options, driver.Roots());
  ASSERT_EQ(source.Open(), "");
  const test::CaptureCost cost = test::MeasureCapture(source, 2000);
  EXPECT_EQ(cost.problem, "");
  EXPECT_LE(cost.places, options.camera.buffers);  // nothing is copied
}

}  // namespace
}  // namespace chequer
