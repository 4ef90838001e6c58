#include "golden/judge.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

namespace chequer::golden {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
/// A detection is meant to be of the marker whose centre is that near, or within a cell.
constexpr double kSamePlacePx = 3;

/// The marker in whose place a detection is; null where there is none.
const ExpectedMarker* MarkerAt(const ExpectedFrame& frame, const Eigen::Vector2d& center_px) {
  const ExpectedMarker* nearest = nullptr;
  double nearest_px = 0;
  for (const ExpectedMarker& marker : frame.markers) {
    const double distance_px = (marker.center_px - center_px).norm();
    if (distance_px > std::max(kSamePlacePx, marker.cell_px)) continue;
    if (nearest != nullptr && distance_px >= nearest_px) continue;
    nearest = &marker;
    nearest_px = distance_px;
  }
  return nearest;
}

std::string Describe(const MarkerPose& detection) {
  std::ostringstream text;
  text << ToString(detection.size) << " " << VariantName(detection.variant) << " ";
  text << (detection.id ? "id " + std::to_string(*detection.id) : std::string("board without id"));
  text << " at (" << std::lround(detection.center_px.x()) << ", " << std::lround(detection.center_px.y()) << ")";
  return text.str();
}

class FrameJudge {
 public:
  FrameJudge(const GoldenScene& scene, const ExpectedFrame& frame, Verdict& verdict)
      : scene_(scene), frame_(frame), verdict_(verdict) {}

  void JudgeDetection(const MarkerPose& detection) {
    const ExpectedMarker* marker = MarkerAt(frame_, detection.center_px);
    if (marker == nullptr) return Fail(Describe(detection) + " where no marker is");
    if (!detection.id) {
      ++verdict_.undecided;
      return;
    }
    if (*detection.id != marker->id || detection.variant != marker->variant || detection.size != marker->size) {
      return Fail(Describe(detection) + " is in truth " + ToString(marker->size) + " " +
                  std::string(VariantName(marker->variant)) + " id " + std::to_string(marker->id));
    }
    if (std::find(found_.begin(), found_.end(), marker) != found_.end()) {
      return Fail(Describe(detection) + " is found twice");
    }
    found_.push_back(marker);
    ++verdict_.detected;
    JudgeCorners(detection, *marker);
    JudgePose(detection, *marker);
  }

 private:
  void Fail(const std::string& what) { verdict_.failures.push_back(frame_.file + ": " + what); }

  void Limit(const MarkerPose& detection, const char* what, double value, double tolerance, double& worst) {
    worst = std::max(worst, value);
    if (value <= tolerance) return;
    std::ostringstream text;
    text << Describe(detection) << ": " << what << " off by " << value << ", allowed " << tolerance;
    Fail(text.str());
  }

  void JudgeCorners(const MarkerPose& detection, const ExpectedMarker& marker) {
    const std::vector<Eigen::Vector2d> truth = marker.CornersPx(*scene_.options.camera);
    double worst_px = 0;
    int seen = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (!detection.corners[i].allFinite()) continue;
      ++seen;
      worst_px = std::max(worst_px, (detection.corners[i].cast<double>() - truth[i]).norm());
    }
    if (seen != detection.corners_used) Fail(Describe(detection) + ": corners_used is not the number of its corners");
    Limit(detection, "a corner (px)", worst_px, scene_.tolerances.corner_px, verdict_.worst_corner_px);
  }

  void JudgePose(const MarkerPose& detection, const ExpectedMarker& marker) {
    if (!detection.has_pose) return Fail(Describe(detection) + " has no pose");
    const RigidTransform& found = detection.camera_from_marker;
    const RigidTransform& truth = marker.camera_from_marker;
    Limit(detection, "position (mm)", 1e3 * (found.translation - truth.translation).norm(),
          scene_.tolerances.position_mm, verdict_.worst_position_mm);
    // Which of two orientations it is cannot be asked where the detection itself says that it does not know.
    if (detection.Has(Warning::kAmbiguous)) return;
    Limit(detection, "orientation (deg)", kDegrees * found.rotation.angularDistance(truth.rotation),
          scene_.tolerances.angle_deg, verdict_.worst_angle_deg);
  }

  const GoldenScene& scene_;
  const ExpectedFrame& frame_;
  Verdict& verdict_;
  std::vector<const ExpectedMarker*> found_;
};

}  // namespace

void JudgeFrame(const GoldenScene& scene, const ExpectedFrame& frame, std::span<const MarkerPose> detections,
                Verdict& verdict) {
  verdict.expected += static_cast<int>(frame.markers.size());
  FrameJudge judge(scene, frame, verdict);
  for (const MarkerPose& detection : detections) judge.JudgeDetection(detection);
}

void JudgeCount(const GoldenScene& scene, Verdict& verdict) {
  if (verdict.detected >= scene.min_detections) return;
  verdict.failures.push_back("found " + std::to_string(verdict.detected) + " markers of " +
                             std::to_string(verdict.expected) + ", at least " + std::to_string(scene.min_detections) +
                             " must be found");
}

}  // namespace chequer::golden
