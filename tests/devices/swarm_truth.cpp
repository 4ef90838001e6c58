#include "devices/swarm_truth.h"

#include <algorithm>
#include <stdexcept>

#include "capture/recording.h"

namespace chequer::test {
namespace {

constexpr double kTolerance = 0.01;  ///< of the distance

/// What is wrong with a message if it is of that frame; empty if nothing.
std::string JudgeFrame(const PosesMessage& message, const FrameTruth& truth) {
  for (const MarkerPose& found : message.markers) {
    if (!found.id) return "an id is undecided";
    const auto marker = std::find_if(truth.markers.begin(), truth.markers.end(),
                                     [&](const TrueMarker& candidate) { return candidate.id == *found.id; });
    if (marker == truth.markers.end()) return "marker " + std::to_string(*found.id) + " is not in the frame";
    const Eigen::Vector3d& position = marker->camera_from_marker.translation;
    const double error_m = (found.camera_from_marker.translation - position).norm();
    if (!found.has_pose || error_m > kTolerance * position.norm())
      return "marker " + std::to_string(*found.id) + " is off by " + std::to_string(1000 * error_m) + " mm";
  }
  if (message.markers.size() == truth.markers.size()) return {};
  return std::to_string(message.markers.size()) + " of " + std::to_string(truth.markers.size()) + " markers were found";
}

/// How far the markers of a message are from where they are in a frame.
double Distance(const PosesMessage& message, const FrameTruth& truth) {
  double sum = 0;
  for (const MarkerPose& found : message.markers)
    for (const TrueMarker& marker : truth.markers)
      if (found.id && marker.id == *found.id)
        sum += (found.camera_from_marker.translation - marker.camera_from_marker.translation).norm();
  return sum;
}

}  // namespace

SwarmTruth::SwarmTruth(const std::filesystem::path& recording) {
  const RecordingInfo info = OpenRecording(recording).info;
  if (info.truth.empty()) throw std::runtime_error(recording.string() + " has no truth");
  frames_ = ReadTruth(recording / info.truth);
}

std::string SwarmTruth::Judge(const PosesMessage& message) const {
  const auto nearest = std::min_element(frames_.begin(), frames_.end(), [&](const auto& a, const auto& b) {
    return Distance(message, a) < Distance(message, b);
  });
  const std::string wrong = JudgeFrame(message, *nearest);
  return wrong.empty() ? "" : "frame " + std::to_string(message.sequence) + ": " + wrong;
}

}  // namespace chequer::test
