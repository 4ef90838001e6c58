#include "detect/plane_pose.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace chequer {
namespace {

using Parameters = BoardGeometry::Parameters;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using ByPose = HomographyByPose;

constexpr int kMaxSteps = 12;
/// A step that explains so little more, as a share of what is unexplained plus one, ends the descent.
constexpr double kSettled = 1e-6;

/// The homography's parameters of a pose: focal · cell · [r₁ r₂ t/cell] over its last entry t_z.
Parameters Homography(const RigidTransform& pose, double cell_m, double focal, ByPose* by_pose) {
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  const Eigen::Vector3d& t = pose.translation;
  const double w = 1 / t.z(), scale[3] = {focal * w, focal * w, w};
  Parameters h;
  for (int row = 0; row < 3; ++row) {
    h[3 * row] = scale[row] * cell_m * rotation(row, 0);
    h[3 * row + 1] = scale[row] * cell_m * rotation(row, 1);
    if (row < 2) h[3 * row + 2] = scale[row] * t[row];
  }
  by_pose->setZero();
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 2; ++col) {
      // A small turn θ moves a column r by θ × r.
      const Eigen::Vector3d r = scale[row] * cell_m * rotation.col(col);
      const int i = 3 * row + col;
      const int next = (row + 1) % 3, last = (row + 2) % 3;
      (*by_pose)(i, 3 + next) = r[last];
      (*by_pose)(i, 3 + last) = -r[next];
    }
    if (row < 2) (*by_pose)(3 * row + 2, row) = scale[row];
  }
  by_pose->col(2) = -w * h;
  return h;
}

/// Levenberg and Marquardt's descent; χ² is infinite if the board came behind the camera.
PlanePose Descend(RigidTransform pose, const MeasuredHomography& measured, double cell_m, double focal) {
  PlanePose best{pose, Matrix6d::Identity(), std::numeric_limits<double>::infinity()};
  const Parameters target = measured.geometry.parameters();
  Matrix6d normal;
  Vector6d gradient;
  double damping = 0;
  for (int step = 0; step < kMaxSteps; ++step) {
    if (!(pose.translation.z() > 1e-9)) break;
    ByPose by_pose;
    const Parameters residual = target - Homography(pose, cell_m, focal, &by_pose);
    const Parameters weighted = measured.information.lazyProduct(residual);
    const double chi_square = residual.dot(weighted);
    if (chi_square < best.chi_square) {
      const bool settled = best.chi_square - chi_square < kSettled * (chi_square + 1);
      // Eigen's products of that size are made for larger ones.
      const ByPose weighted_by_pose = measured.information.lazyProduct(by_pose);
      normal = by_pose.transpose().lazyProduct(weighted_by_pose);
      gradient = by_pose.transpose().lazyProduct(weighted);
      best.camera_from_board = pose;
      best.chi_square = chi_square;
      if (settled) break;
      damping /= 10;
    } else {
      // Back to the best pose, with a shorter step.
      damping = std::max(10 * damping, 1e-3);
      if (damping > 1e3) break;
    }
    Matrix6d damped = normal;
    damped.diagonal() *= 1 + damping;
    const Vector6d move = damped.llt().solve(gradient);
    if (!move.allFinite()) break;
    pose.translation = best.camera_from_board.translation + move.head<3>();
    pose.rotation = (RotationFromVector(move.tail<3>()) * best.camera_from_board.rotation).normalized();
  }
  if (std::isfinite(best.chi_square)) best.covariance = normal.llt().solve(Matrix6d::Identity());
  return best;
}

}  // namespace

Parameters HomographyOfPose(const RigidTransform& camera_from_board, double cell_m, double focal,
                            HomographyByPose* by_pose) {
  return Homography(camera_from_board, cell_m, focal, by_pose);
}

std::optional<std::array<PlanePose, 2>> PlanePoses(const MeasuredHomography& measured, double cell_m, double focal) {
  const Eigen::Matrix3d& h = measured.geometry.plane_from_board();
  // First-order behaviour of the homography at the board's origin, on the plane z = 1.
  const Eigen::Vector2d p = h.block<2, 1>(0, 2) / focal;
  const Eigen::Matrix2d jacobian = measured.geometry.PlaneByBoard({0, 0}) / focal;
  if (!jacobian.allFinite() || !(jacobian.determinant() > 0)) return std::nullopt;
  // A camera that looks straight at the point sees the board by a 2 × 2 matrix A = γ R₂₂ (IPPE, section 3.2).
  const Eigen::Matrix3d to_sight =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), Eigen::Vector3d(p.x(), p.y(), 1)).toRotationMatrix();
  const Eigen::Matrix2d b = to_sight.topLeftCorner<2, 2>() - p * to_sight.block<1, 2>(2, 0);
  const Eigen::Matrix2d a = b.inverse() * jacobian;
  const double trace = a.squaredNorm(), determinant = a.determinant();
  const double gamma =
      std::sqrt(0.5 * (trace + std::sqrt(std::max(trace * trace - 4 * determinant * determinant, 0.0))));
  const Eigen::Matrix2d r = a / gamma;
  const double b0 = std::sqrt(std::max(1 - r.col(0).squaredNorm(), 0.0));
  double b1 = std::sqrt(std::max(1 - r.col(1).squaredNorm(), 0.0));
  if (-r.col(0).dot(r.col(1)) < 0) b1 = -b1;
  // γ is the size of a cell over the distance along the line of sight.
  const Eigen::Vector3d translation = cell_m / gamma * Eigen::Vector3d(p.x(), p.y(), 1).normalized();
  std::array<PlanePose, 2> poses;
  for (std::size_t i = 0; i < 2; ++i) {
    const double sign = i == 0 ? 1 : -1;
    Eigen::Matrix3d rotation;
    rotation.col(0) << r(0, 0), r(1, 0), sign * b0;
    rotation.col(1) << r(0, 1), r(1, 1), sign * b1;
    rotation.col(2) = rotation.col(0).cross(rotation.col(1));
    const RigidTransform start{Eigen::Quaterniond(Eigen::Matrix3d(to_sight * rotation)).normalized(), translation};
    poses[i] = Descend(start, measured, cell_m, focal);
  }
  if (poses[1].chi_square < poses[0].chi_square) std::swap(poses[0], poses[1]);
  if (!std::isfinite(poses[0].chi_square)) return std::nullopt;
  return poses;
}

}  // namespace chequer
