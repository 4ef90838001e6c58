#include "detect/common/board_geometry.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "core/lens_parameters.h"

namespace chequer {

namespace {

/// A root of a covariance, which may be singular.
LensCovariance RootOf(const LensCovariance& covariance) {
  const Eigen::LDLT<LensCovariance> factor(covariance);
  const LensCovariance lower = factor.matrixL();
  return factor.transpositionsP().transpose() *
         LensCovariance(lower * factor.vectorD().cwiseMax(0).cwiseSqrt().asDiagonal());
}

}  // namespace

Lens::Lens(const CameraModel& camera)
    : camera_(camera),
      uncertain_(!camera.covariance.isZero(0)),
      calibrated_(true),
      focal_(std::sqrt(camera.fx * camera.fy)),
      by_focal_(1 / focal_) {
  if (uncertain_) deviations_ = RootOf(camera.covariance);
}

Eigen::Matrix<double, 2, 9> Lens::PlaneByCalibration(const Eigen::Vector2d& plane) const {
  if (!uncertain_) return Eigen::Matrix<double, 2, 9>::Zero();
  // The pixel stays where it is: what the lens's numbers move, the point moves back.
  const Eigen::Vector2d normalized = plane / focal_;
  Eigen::Matrix2d pixel_by_normalized;
  camera_.Distort(normalized, &pixel_by_normalized);
  const auto seen = ProjectWithDerivatives(camera_, normalized.homogeneous());
  return -focal_ * (pixel_by_normalized.inverse() * (seen->by_lens * deviations_));
}

std::optional<Eigen::Vector2d> Lens::ToPlane(const Eigen::Vector2d& pixel) const {
  if (!calibrated_) return pixel;
  const std::optional<Eigen::Vector2d> normalized = camera_.Undistort(pixel);
  if (!normalized) return std::nullopt;
  return focal_ * *normalized;
}

Eigen::Vector2d Lens::ToImage(const Eigen::Vector2d& plane) const {
  return calibrated_ ? camera_.Distort(plane * by_focal_) : plane;
}

Eigen::Vector2d Lens::ToImage(const Eigen::Vector2d& plane, Eigen::Matrix2d* jacobian) const {
  if (!calibrated_) {
    jacobian->setIdentity();
    return plane;
  }
  const Eigen::Vector2d pixel = camera_.Distort(plane * by_focal_, jacobian);
  *jacobian *= by_focal_;
  return pixel;
}

BoardGeometry::Parameters BoardGeometry::parameters() const {
  Parameters h;
  for (int i = 0; i < kParameters; ++i) h[i] = plane_from_board_(i / 3, i % 3);
  return h;
}

double BoardGeometry::CellSide() const { return std::sqrt(std::abs(PlaneByBoard({0, 0}).determinant())); }

Eigen::Matrix2d BoardGeometry::PlaneByBoard(const Eigen::Vector2d& board) const {
  const Eigen::Vector3d h = plane_from_board_ * board.homogeneous();
  const Eigen::Vector2d plane = h.hnormalized();
  return (plane_from_board_.topLeftCorner<2, 2>() - plane * plane_from_board_.block<1, 2>(2, 0)) / h.z();
}

BoardGeometry::Derivative BoardGeometry::PlaneByParameters(const Eigen::Vector2d& board) const {
  const Eigen::Vector3d h = plane_from_board_ * board.homogeneous();
  const double w = 1 / h.z(), x = board.x() * w, y = board.y() * w, u = h.x() * w, v = h.y() * w;
  Derivative derivative;
  derivative << x, y, w, 0, 0, 0, -u * x, -u * y,  //
      0, 0, 0, x, y, w, -v * x, -v * y;
  return derivative;
}

void BoardGeometry::Add(const Parameters& step) {
  for (int i = 0; i < kParameters; ++i) plane_from_board_(i / 3, i % 3) += step[i];
}

void BoardGeometry::MoveCoordinates(const Parameters& m) {
  // A point (x, y, 1) comes to (I + A)(x, y, 1).
  Eigen::Matrix3d moved;
  moved << 1 + m[1], m[2], m[0], m[4], 1 + m[5], m[3], -m[6], -m[7], 1;
  plane_from_board_ *= moved.inverse();
  plane_from_board_ /= plane_from_board_(2, 2);
}

BoardGeometry::Information BoardGeometry::ParametersByMoves() const {
  Information by_moves;
  for (int i = 0; i < kParameters; ++i) {
    const Parameters m = Parameters::Unit(i);
    // As in MoveCoordinates: the homography H becomes H (I − A), to first order, its last entry 1 again.
    Eigen::Matrix3d a;
    a << m[1], m[2], m[0], m[4], m[5], m[3], -m[6], -m[7], 0;
    const Eigen::Matrix3d moved = plane_from_board_ * a;
    const Eigen::Matrix3d change = moved(2, 2) * plane_from_board_ - moved;
    by_moves.col(i) << change.row(0).transpose(), change.row(1).transpose(), change(2, 0), change(2, 1);
  }
  return by_moves;
}

BoardGeometry::Information BoardGeometry::FromMoves(const Information& of_moves) const {
  // A change δH of the homography H is the move A = μ I − H⁻¹ δH, with the μ that leaves A's last entry 0.
  const Eigen::Matrix3d inverse = plane_from_board_.inverse();
  Information moves = Information::Zero();
  for (int i = 0; i < kParameters; ++i) {
    const int row = i / 3, col = i % 3;
    auto move = moves.col(i);
    if (col < 2) {
      move[1 + col] = -inverse(0, row);
      move[4 + col] = -inverse(1, row);
      move[6 + col] = inverse(2, row);
    } else {
      move[0] = -inverse(0, row);
      move[3] = -inverse(1, row);
      move[1] = move[5] = inverse(2, row);
    }
  }
  const Information weighted = of_moves.lazyProduct(moves);
  return moves.transpose().lazyProduct(weighted);
}

RigidTransform CameraFromMarker(const RigidTransform& camera_from_board) {
  // Half a turn about x.
  return {(camera_from_board.rotation * Eigen::Quaterniond(0, 1, 0, 0)).normalized(), camera_from_board.translation};
}

}  // namespace chequer
