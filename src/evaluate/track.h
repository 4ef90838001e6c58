#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "chequer/geometry.h"

namespace chequer {

/// How large errors are, in the forms the publication gives them (equations 6, 7 for positions, 8, 9 for
/// orientations). None is negative.
struct ErrorMeasures {
  double rmse = 0;  ///< the usual one: √(Σ e² / n)
  double mae = 0;   ///< the usual one: Σ e / n
  /// √(Σ e²) / n, which the printed equation is read as: the mean outside the root, so it falls with a run's length.
  double printed_rmse = 0;
  double printed_mae = 0;  ///< Σ e / n, as the usual one
  double largest = 0;
};
/// All zero for no errors. @pre none is negative.
ErrorMeasures MeasureErrors(std::span<const double> errors);

/// A run along a straight track in one orientation, as measured: the truth that the publication measures against is the
/// line and the orientation that fit the run best, so that neither the track nor the camera has to be surveyed.
struct TrackFit {
  // Equation 5: the line with the least squared distances from the positions.
  Eigen::Vector3d center{0, 0, 0};     ///< of the positions, metres; a point of the line
  Eigen::Vector3d direction{1, 0, 0};  ///< unit, from the first position to the last
  /// The rotation nearest to all (least squared chordal distances).
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();

  /// By pose: where along the line it lies, from the centre; how far beside it. Metres.
  std::vector<double> along_m, distance_m;
  /// By pose: angle to `orientation`, degrees.
  std::vector<double> angle_deg;
};

/// Whether a run leaves its best line, or turns, far and in one sweep: then distances and angles are those of the path,
/// and no errors. Errors of measuring go back and forth from pose to pose.
struct TrackShape {
  bool is_straight = true;
  bool is_turning = false;
};
/// @pre at least three poses, in the order of time; `fit` is theirs.
TrackShape ShapeOf(std::span<const RigidTransform> poses, const TrackFit& fit);

/// @pre at least three poses.
TrackFit FitTrack(std::span<const RigidTransform> poses);

/// A track's errors: millimetres and degrees.
struct TrackErrors {
  double linear_rms_mm = 0;  ///< of the distances from the line
  double linear_mean_mm = 0;
  double angular_rms_deg = 0;  ///< of the angles to the mean orientation
  double angular_mean_deg = 0;
};
/// In the usual form. @pre at least three poses.
TrackErrors MeasureTrack(std::span<const RigidTransform> poses);

/// The angle between two orientations, degrees, 0..180.
double AngleBetweenDeg(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

}  // namespace chequer
