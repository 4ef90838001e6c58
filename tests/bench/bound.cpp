#include "bench/bound.h"

#include <cmath>
#include <numbers>

namespace chequer::bench {

ErrorBound BoundOfTrack(std::span<const RigidTransform> truth, std::span<const Matrix6d> covariances) {
  const TrackFit track = FitTrack(truth);
  const std::size_t n = truth.size();
  const auto count = static_cast<double>(n);
  double spread = 0;
  for (const double s : track.along_m) spread += s * s;
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - track.direction * track.direction.transpose();
  double position = 0, angle = 0, linear = 0, angular = 0;
  for (std::size_t j = 0; j < n; ++j) {
    const Eigen::Matrix3d of_position = covariances[j].topLeftCorner<3, 3>();
    const double beside = (across * of_position).trace(), turn = covariances[j].bottomRightCorner<3, 3>().trace();
    position += of_position.trace() / count;
    angle += turn / count;
    // What the fitted line (two unknowns along each axis across it) and the fitted orientation leave of each error.
    for (std::size_t i = 0; i < n; ++i) {
      const double itself = i == j ? 1 : 0;
      const double by_line = itself - 1 / count - track.along_m[i] * track.along_m[j] / spread;
      const double by_mean = itself - 1 / count;
      linear += by_line * by_line * beside / count;
      angular += by_mean * by_mean * turn / count;
    }
  }
  constexpr double kMillimetres = 1e3, kDegrees = 180 / std::numbers::pi;
  return {kMillimetres * std::sqrt(position),
          kDegrees * std::sqrt(angle),
          {.linear_rms_mm = kMillimetres * std::sqrt(linear), .angular_rms_deg = kDegrees * std::sqrt(angular)}};
}

ErrorBounds BoundsOfTrack(std::span<const RigidTransform> truth, std::span<const PoseBounds> bounds) {
  std::vector<Matrix6d> alone, levels_known;
  for (const PoseBounds& bound : bounds) {
    alone.push_back(bound.alone);
    levels_known.push_back(bound.levels_known);
  }
  return {BoundOfTrack(truth, alone), BoundOfTrack(truth, levels_known)};
}

}  // namespace chequer::bench
