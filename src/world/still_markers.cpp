#include "world/still_markers.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// Frames beyond this add nothing that counts.
constexpr std::size_t kMostPoses = 300;
/// A board seen nearly head-on has two poses, mirror images of each other; those that differ so much from what most
/// have are of the other kind.
constexpr double kOtherPoseRad = 0.17;
/// What calibration of the lens leaves wrong and no averaging takes out, as a share of the distance, along the line of
/// sight: 2 parts in 10 000 go with a focal length that is good to as much.
constexpr double kSystematic = 2e-4;

/// The pose whose orientation most others share.
const MarkerPose& MostShared(const std::vector<MarkerPose>& poses) {
  std::size_t best = 0;
  std::ptrdiff_t most = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Quaterniond& here = poses[i].camera_from_marker.rotation;
    const auto shared = std::count_if(poses.begin(), poses.end(), [&](const MarkerPose& other) {
      return other.camera_from_marker.rotation.angularDistance(here) <= kOtherPoseRad;
    });
    if (shared <= most) continue;
    most = shared;
    best = i;
  }
  return poses[best];
}

StillMarker Mean(const std::vector<MarkerPose>& poses) {
  const MarkerPose& best = MostShared(poses);
  StillMarker mean;
  mean.id = *best.id;
  mean.family = best.family;
  mean.size = best.size;
  mean.variant = best.variant;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d weighted = Eigen::Vector3d::Zero(), turn = Eigen::Vector3d::Zero();
  Matrix6d varying = Matrix6d::Zero(), print = Matrix6d::Zero();
  int turns = 0;
  for (const MarkerPose& pose : poses) {
    const Eigen::Matrix3d weight = pose.covariance.topLeftCorner<3, 3>().inverse();
    information += weight;
    weighted += weight * pose.camera_from_marker.translation;
    varying += pose.covariance - pose.print_covariance;
    print += pose.print_covariance;
    const Eigen::Vector3d from_best =
        VectorFromRotation(pose.camera_from_marker.rotation * best.camera_from_marker.rotation.inverse());
    if (from_best.norm() > kOtherPoseRad) continue;
    turn += from_best;
    ++turns;
  }
  const double n = static_cast<double>(poses.size());
  mean.frames = static_cast<int>(poses.size());
  mean.camera_from_marker.translation = information.inverse() * weighted;
  mean.camera_from_marker.rotation =
      Canonical(RotationFromVector(turn / std::max(turns, 1)) * best.camera_from_marker.rotation);
  // What a print is off is the same in all frames.
  mean.covariance = varying / (n * n) + print / n;
  const Eigen::Vector3d along = kSystematic * mean.camera_from_marker.translation;
  mean.covariance.topLeftCorner<3, 3>() += along * along.transpose();
  const Eigen::Vector3d sight = mean.camera_from_marker.translation.normalized();
  for (const MarkerPose& pose : poses) {
    const Eigen::Vector3d off = pose.camera_from_marker.translation - mean.camera_from_marker.translation;
    mean.spread_m = std::max(mean.spread_m, (off - sight * sight.dot(off)).norm());
  }
  return mean;
}

}  // namespace

void StillMarkers::Add(std::span<const MarkerPose> markers) {
  ++frames_;
  for (const MarkerPose& marker : markers) {
    if (!marker.id || !marker.has_pose) continue;
    std::vector<MarkerPose>& poses = poses_[{marker.family, *marker.id}];
    if (poses.size() < kMostPoses) poses.push_back(marker);
  }
}

std::vector<StillMarker> StillMarkers::Means() const {
  std::vector<StillMarker> means;
  for (const auto& [key, poses] : poses_) means.push_back(Mean(poses));
  return means;
}

}  // namespace chequer
