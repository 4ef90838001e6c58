#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "chequer/check.h"
#include "chequer/detector.h"
#include "fuzz/frame_input.h"

namespace {

chequer::DetectorOptions Options() {
  using namespace chequer;
  DetectorOptions options;
  options.families = {{MarkerCode({6, 6}, Variant::kSecded), 0.1, {}},
                      {MarkerCode({4, 4}, Variant::kUnconstrained), 0.1, {}}};
  CameraModel camera;
  camera.width = camera.height = 64;
  camera.fx = camera.fy = 60;
  camera.cx = camera.cy = 31.5;
  options.camera = camera;
  return options;
}

}  // namespace

// Any image: markers whose numbers are numbers.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static chequer::Detector detector(Options());
  const auto frame = chequer::fuzz::FrameOf(data, size);
  if (!frame) return 0;
  for (const chequer::MarkerPose& marker : detector.Detect(*frame)) {
    CHEQUER_CHECK(marker.center_px.allFinite(), "a marker's centre is not finite");
    CHEQUER_CHECK(marker.corners_used > 0, "a marker without corners");
    if (!marker.has_pose) continue;
    CHEQUER_CHECK(marker.camera_from_marker.translation.allFinite(), "a position is not finite");
    CHEQUER_CHECK(marker.camera_from_marker.rotation.coeffs().allFinite(), "an orientation is not finite");
    CHEQUER_CHECK(marker.covariance.allFinite(), "a covariance is not finite");
  }
  return 0;
}
