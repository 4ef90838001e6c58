// What capturing a frame and handing it over costs beyond the driver's own work: the fake driver takes no time.
#include <cstdio>

#include "capture/v4l2_source.h"
#include "devices/camera_test_tools.h"
#include "support/fake_v4l2.h"

namespace {
constexpr int kFrames = 2000;
/// Of a frame's 16.7 ms at 60 a second, capturing may take this little.
constexpr double kMostMs = 0.3;
}  // namespace

int main() {
  const chequer::test::FakeV4l2 driver;
  chequer::V4l2Options options;
  options.camera.device = "Fake";
  options.camera.fps = 60;
  chequer::V4l2Source source(options, driver.Roots());
  if (const std::string problem = source.Open(); !problem.empty()) {
    std::fprintf(stderr, "capture_cost: %s\n", problem.c_str());
    return 1;
  }
  const chequer::test::CaptureCost cost = chequer::test::MeasureCapture(source, kFrames);
  if (!cost.problem.empty()) {
    std::fprintf(stderr, "capture_cost: %s\n", cost.problem.c_str());
    return 1;
  }
  std::printf("1920x1080: %.4f ms of processor a frame, handed over in %.4f ms\n", cost.cpu_ms, cost.hand_over_ms);
  const bool quick = cost.cpu_ms + cost.hand_over_ms < kMostMs;
  if (!quick) std::printf("MISSED: at most %.1f ms\n", kMostMs);
  return quick ? 0 : 1;
}
