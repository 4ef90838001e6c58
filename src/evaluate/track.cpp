#include "evaluate/track.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "chequer/check.h"
#include "core/rotations.h"

namespace chequer {
namespace {

constexpr double kMillimetres = 1e3;
constexpr double kDegrees = 180.0 / std::numbers::pi;

void FitLine(std::span<const RigidTransform> poses, TrackFit& fit) {
  for (const RigidTransform& pose : poses) fit.center += pose.translation / static_cast<double>(poses.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const RigidTransform& pose : poses) {
    const Eigen::Vector3d off = pose.translation - fit.center;
    scatter += off * off.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  fit.direction = solver.eigenvectors().col(2);  // eigenvalues ascend
  if (fit.direction.dot(poses.back().translation - poses.front().translation) < 0) fit.direction = -fit.direction;
  for (const RigidTransform& pose : poses) {
    const Eigen::Vector3d off = pose.translation - fit.center;
    fit.along_m.push_back(off.dot(fit.direction));
    fit.distance_m.push_back(off.cross(fit.direction).norm());
  }
}

void FitOrientation(std::span<const RigidTransform> poses, TrackFit& fit) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const RigidTransform& pose : poses) sum += pose.rotation.toRotationMatrix();
  fit.orientation = Canonical(Eigen::Quaterniond(FindNearestRotation(sum).rotation));
  for (const RigidTransform& pose : poses) fit.angle_deg.push_back(AngleBetweenDeg(fit.orientation, pose.rotation));
}

}  // namespace

ErrorMeasures MeasureErrors(std::span<const double> errors) {
  ErrorMeasures measures;
  if (errors.empty()) return measures;
  double sum = 0, square = 0;
  for (const double error : errors) {
    sum += error;
    square += error * error;
    measures.largest = std::max(measures.largest, error);
  }
  const auto n = static_cast<double>(errors.size());
  measures.rmse = std::sqrt(square / n);
  measures.mae = measures.printed_mae = sum / n;
  measures.printed_rmse = std::sqrt(square) / n;
  return measures;
}

TrackFit FitTrack(std::span<const RigidTransform> poses) {
  CHEQUER_CHECK(poses.size() >= 3, "a line through fewer than three positions has no errors");
  TrackFit fit;
  FitLine(poses, fit);
  FitOrientation(poses, fit);
  return fit;
}

TrackShape ShapeOf(std::span<const RigidTransform> poses, const TrackFit& fit) {
  // Millimetres and degrees that a poor measurement may be off by, and shares of the track's length that a lens that is
  // calibrated badly may bend it by.
  constexpr double kLeastOff = 0.003, kLeastShare = 0.02, kLeastTurnDeg = 5;
  // Of independent errors, steps from one to the next have twice the variance; of a path's, little of it (von Neumann's
  // ratio).
  constexpr double kSmooth = 0.3;
  std::vector<Eigen::Vector3d> beside;
  double off = 0, off_steps = 0, turn = 0, turn_steps = 0;
  for (const RigidTransform& pose : poses) {
    const Eigen::Vector3d from_center = pose.translation - fit.center;
    beside.push_back(from_center - fit.direction * from_center.dot(fit.direction));
    off += beside.back().squaredNorm();
  }
  for (const double angle : fit.angle_deg) turn += angle * angle;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    off_steps += (beside[i] - beside[i - 1]).squaredNorm();
    turn_steps += std::pow(AngleBetweenDeg(poses[i].rotation, poses[i - 1].rotation), 2);
  }
  const auto [first, last] = std::minmax_element(fit.along_m.begin(), fit.along_m.end());
  const auto n = static_cast<double>(poses.size());
  TrackShape shape;
  shape.is_straight =
      std::sqrt(off / n) < std::max(kLeastOff, kLeastShare * (*last - *first)) || off_steps > kSmooth * 2 * off;
  shape.is_turning = std::sqrt(turn / n) > kLeastTurnDeg && turn_steps < kSmooth * 2 * turn;
  return shape;
}

TrackErrors MeasureTrack(std::span<const RigidTransform> poses) {
  const TrackFit fit = FitTrack(poses);
  const ErrorMeasures linear = MeasureErrors(fit.distance_m), angular = MeasureErrors(fit.angle_deg);
  return {kMillimetres * linear.rmse, kMillimetres * linear.mae, angular.rmse, angular.mae};
}

double AngleBetweenDeg(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return a.angularDistance(b) * kDegrees;
}

}  // namespace chequer
