#include "bench/score.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace chequer::bench {
namespace {

constexpr double kMillimetres = 1e3;
constexpr double kMinMatchRadiusPx = 3;

double RootMeanSquare(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

}  // namespace

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*middle + *std::max_element(values.begin(), middle)) / 2;
}

double MeanOfStream(std::span<const double> frames) {
  const std::span<const double> known = frames.subspan(kFramesUntilKnown);
  return std::accumulate(known.begin(), known.end(), 0.0) / static_cast<double>(known.size());
}

void ScoreKeeper::AddFrame(std::span<const TrueMarker> truth, std::span<const Detection> detections) {
  std::vector<bool> used(detections.size());
  for (const TrueMarker& marker : truth) {
    ++counts_.markers;
    double nearest_px = std::max(kMinMatchRadiusPx, marker.cell_px);
    std::optional<std::size_t> match;
    for (std::size_t i = 0; i < detections.size(); ++i) {
      const Eigen::Vector3d& position = detections[i].camera_from_marker.translation;
      if (used[i] || detections[i].id != marker.id || !(position.z() > 0)) continue;
      const double distance_px = (camera_.Project(position) - marker.center_px).norm();
      if (!(distance_px < nearest_px)) continue;
      nearest_px = distance_px;
      match = i;
    }
    if (!match) continue;
    used[*match] = true;
    AddHit(marker, detections[*match].camera_from_marker);
  }
  for (std::size_t i = 0; i < detections.size(); ++i) {
    if (used[i]) continue;
    ++(detections[i].id ? counts_.wrong : counts_.undecided);
  }
}

void ScoreKeeper::AddHit(const TrueMarker& truth, const RigidTransform& found) {
  ++counts_.hits;
  const Eigen::Vector3d line_of_sight = truth.camera_from_marker.translation.normalized();
  const Eigen::Vector3d error = found.translation - truth.camera_from_marker.translation;
  const double depth = error.dot(line_of_sight);
  found_.push_back(found);
  position_m_.push_back(error.norm());
  depth_m_.push_back(depth);
  lateral_m_.push_back((error - depth * line_of_sight).norm());
  angle_deg_.push_back(AngleBetweenDeg(found.rotation, truth.camera_from_marker.rotation));
}

Score ScoreKeeper::Summary() const {
  Score score = counts_;
  if (score.hits == 0) return score;
  score.pose = PoseErrors{kMillimetres * RootMeanSquare(position_m_),
                          kMillimetres * Median(position_m_),
                          kMillimetres * RootMeanSquare(lateral_m_),
                          kMillimetres * RootMeanSquare(depth_m_),
                          RootMeanSquare(angle_deg_),
                          Median(angle_deg_)};
  if (score.hits >= 3) score.track = MeasureTrack(found_);
  return score;
}

}  // namespace chequer::bench
