#include "bench/score.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace chequer::bench {
namespace {

constexpr double kMillimetres = 1e3;
constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kMinMatchRadiusPx = 3;

double RootMeanSquare(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double Mean(std::span<const double> values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Distances of points from the straight line that fits them best.
std::vector<double> DistancesFromLine(std::span<const RigidTransform> poses) {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const RigidTransform& pose : poses) center += pose.translation / static_cast<double>(poses.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const RigidTransform& pose : poses) {
    scatter += (pose.translation - center) * (pose.translation - center).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  const Eigen::Vector3d direction = solver.eigenvectors().col(2);  // eigenvalues ascend
  std::vector<double> distances;
  for (const RigidTransform& pose : poses) distances.push_back((pose.translation - center).cross(direction).norm());
  return distances;
}

/// Angles to the rotation nearest to the sum of all, degrees.
std::vector<double> AnglesFromMean(std::span<const RigidTransform> poses) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const RigidTransform& pose : poses) sum += pose.rotation.toRotationMatrix();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  const Eigen::Matrix3d mean = svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
  std::vector<double> angles;
  for (const RigidTransform& pose : poses) angles.push_back(AngleBetweenDeg(Eigen::Quaterniond(mean), pose.rotation));
  return angles;
}

}  // namespace

double AngleBetweenDeg(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return a.angularDistance(b) * kDegrees;
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*middle + *std::max_element(values.begin(), middle)) / 2;
}

TrackErrors MeasureTrack(std::span<const RigidTransform> poses) {
  const std::vector<double> distances = DistancesFromLine(poses);
  const std::vector<double> angles = AnglesFromMean(poses);
  return {kMillimetres * RootMeanSquare(distances), kMillimetres * Mean(distances), RootMeanSquare(angles),
          Mean(angles)};
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
