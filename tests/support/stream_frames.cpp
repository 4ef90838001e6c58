#include "support/stream_frames.h"

#include <algorithm>
#include <map>
#include <utility>

namespace chequer::test {

StreamScore& StreamScore::operator+=(const StreamScore& other) {
  expected += other.expected;
  read += other.read;
  wrong += other.wrong;
  twice += other.twice;
  return *this;
}

StreamFrames StreamFrames::Example(const std::string& name) {
  return StreamFrames(
      LoadScenario(std::filesystem::path(CHEQUER_TEST_DATA).parent_path() / "examples/scenarios" / (name + ".toml")));
}

StreamFrames::StreamFrames(std::string_view scenario) : StreamFrames(ParseScenario(scenario, "scenario")) {}

StreamFrames::StreamFrames(Scenario scenario) : stream_(std::move(scenario)) {}

const std::string& StreamFrames::phase(std::size_t index) const {
  return scenario().phases[stream_.plan(index).phase].name;
}

StreamFrame StreamFrames::Frame(std::size_t index, std::uint64_t round) const {
  return {stream_.Draw(index, round), stream_.Truth(index)};
}

DetectorOptions StreamFrames::Options() const {
  const ScenarioSwarm& swarm = scenario().swarm;
  DetectorOptions options;
  options.families = {{.code = MarkerCode(swarm.size, swarm.variant), .side_m = swarm.side_m, .roster = {}}};
  options.camera = scenario().camera.render.camera;
  return options;
}

StreamScore ScoreFrame(const std::vector<MarkerPose>& found, const FrameTruth& truth) {
  constexpr double kLeastInside = 0.5;
  StreamScore score;
  for (const TrueMarker& marker : truth.markers) score.expected += marker.inside >= kLeastInside;
  std::map<std::uint64_t, int> seen;
  for (const MarkerPose& pose : found) {
    if (!pose.id) continue;
    const auto match = std::find_if(truth.markers.begin(), truth.markers.end(),
                                    [&](const TrueMarker& marker) { return marker.id == *pose.id; });
    // As far off as half the board is not that board.
    const bool right = match != truth.markers.end() &&
                       (!pose.has_pose ||
                        (pose.camera_from_marker.translation - match->camera_from_marker.translation).head<2>().norm() <
                            0.5 * match->side_m);
    if (!right) {
      ++score.wrong;
    } else if (++seen[*pose.id] > 1) {
      ++score.twice;
    } else {
      score.read += match->inside >= kLeastInside;
    }
  }
  return score;
}

}  // namespace chequer::test
