#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <vector>

#include "chequer/detector.h"

namespace chequer::test {

/// How large the errors of poses are against their covariances: 1 on average where these are honest.
class PoseErrors {
 public:
  void Add(const RigidTransform& camera_from_marker, const MarkerPose& found) {
    const Eigen::Quaterniond turn = camera_from_marker.rotation * found.camera_from_marker.rotation.conjugate();
    position_ += Normalised(camera_from_marker.translation - found.camera_from_marker.translation,
                            found.covariance.topLeftCorner<3, 3>());
    orientation_ += Normalised(VectorFromRotation(turn.normalized()), found.covariance.bottomRightCorner<3, 3>());
    ++poses_;
  }

  /// How far the same markers are off in `others`, which were found as well, or are the truth.
  template <class Marker>
  void AddDifferences(const std::vector<MarkerPose>& found, const std::vector<Marker>& others) {
    for (const MarkerPose& marker : found)
      for (const Marker& other : others)
        if (marker.id && marker.id == other.id) Add(other.camera_from_marker, marker);
  }

  int poses() const { return poses_; }
  /// Means of the squares over what the covariances say of them, per dimension; 0 without poses.
  double position() const { return position_ / std::max(poses_, 1); }
  double orientation() const { return orientation_ / std::max(poses_, 1); }

 private:
  static double Normalised(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
    return error.dot(covariance.inverse() * error) / 3;
  }

  double position_ = 0, orientation_ = 0;
  int poses_ = 0;
};

}  // namespace chequer::test
