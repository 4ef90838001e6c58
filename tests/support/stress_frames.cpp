#include "support/stress_frames.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace chequer::test {

StressCase CaseOf(std::string_view tag, const MarkerCode& code, std::uint64_t seed) {
  const std::vector<StressCase> cases = StressCases(code, seed);
  const auto found =
      std::find_if(cases.begin(), cases.end(), [&](const StressCase& stress) { return stress.tag == tag; });
  if (found == cases.end()) throw std::runtime_error("no condition " + std::string(tag));
  return *found;
}

std::vector<MarkerPose> Look(const StressCase& stress, const MarkerCode& code, std::uint64_t noise_seed) {
  DetectorOptions options;
  options.families = {{.code = code, .side_m = stress.scene.markers[0].side_m, .roster = {}}};
  options.camera = stress.options.camera;
  return Detector(options).Detect(Render(stress.scene, stress.options, noise_seed).view());
}

}  // namespace chequer::test
