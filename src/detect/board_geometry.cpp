#include "detect/board_geometry.h"

#include <Eigen/LU>
#include <cmath>

namespace chequer {

Lens::Lens(const CameraModel& camera) : camera_(camera), calibrated_(true), focal_(std::sqrt(camera.fx * camera.fy)) {}

std::optional<Eigen::Vector2d> Lens::ToPlane(const Eigen::Vector2d& pixel) const {
  if (!calibrated_) return pixel;
  const std::optional<Eigen::Vector2d> normalized = camera_.Undistort(pixel);
  if (!normalized) return std::nullopt;
  return focal_ * *normalized;
}

Eigen::Vector2d Lens::ToImage(const Eigen::Vector2d& plane) const {
  return calibrated_ ? camera_.Distort(plane / focal_) : plane;
}

Eigen::Vector2d Lens::ToImage(const Eigen::Vector2d& plane, Eigen::Matrix2d* jacobian) const {
  if (!calibrated_) {
    jacobian->setIdentity();
    return plane;
  }
  const Eigen::Vector2d pixel = camera_.Distort(plane / focal_, jacobian);
  *jacobian /= focal_;
  return pixel;
}

BoardGeometry BoardGeometry::FromPose(const RigidTransform& camera_from_board, double cell_m, double focal) {
  BoardGeometry geometry;
  geometry.has_pose_ = true;
  geometry.camera_from_board_ = camera_from_board;
  geometry.cell_m_ = cell_m;
  geometry.focal_ = focal;
  geometry.UpdateHomography();
  return geometry;
}

BoardGeometry BoardGeometry::FromHomography(const Eigen::Matrix3d& plane_from_board) {
  BoardGeometry geometry;
  geometry.plane_from_board_ = plane_from_board / plane_from_board(2, 2);
  return geometry;
}

void BoardGeometry::UpdateHomography() {
  const Eigen::Matrix3d rotation = camera_from_board_.rotation.toRotationMatrix();
  plane_from_board_.col(0) = cell_m_ * rotation.col(0);
  plane_from_board_.col(1) = cell_m_ * rotation.col(1);
  plane_from_board_.col(2) = camera_from_board_.translation;
  plane_from_board_.topRows<2>() *= focal_;
}

Eigen::Vector2d BoardGeometry::ToPlane(const Eigen::Vector2d& board) const {
  return (plane_from_board_ * board.homogeneous()).hnormalized();
}

Eigen::Matrix2d BoardGeometry::PlaneByBoard(const Eigen::Vector2d& board) const {
  const Eigen::Vector3d h = plane_from_board_ * board.homogeneous();
  const Eigen::Vector2d plane = h.hnormalized();
  return (plane_from_board_.topLeftCorner<2, 2>() - plane * plane_from_board_.block<1, 2>(2, 0)) / h.z();
}

BoardGeometry::Derivative BoardGeometry::PlaneByParameters(const Eigen::Vector2d& board) const {
  Derivative derivative;
  if (!has_pose_) {
    const Eigen::Vector3d h = plane_from_board_ * board.homogeneous();
    const double w = 1 / h.z(), x = board.x() * w, y = board.y() * w;
    const Eigen::Vector2d plane = h.hnormalized();
    derivative << x, y, w, 0, 0, 0, -plane.x() * x, -plane.x() * y,  //
        0, 0, 0, x, y, w, -plane.y() * x, -plane.y() * y;
    return derivative;
  }
  const Eigen::Vector3d arm =
      camera_from_board_.rotation * Eigen::Vector3d(cell_m_ * board.x(), cell_m_ * board.y(), 0);
  const Eigen::Vector3d p = arm + camera_from_board_.translation;
  const double f = focal_ / p.z(), x = p.x() / p.z(), y = p.y() / p.z();
  // d plane / d p is f [1 0 −x; 0 1 −y]; d p / d θ is −[arm]×.
  derivative << f, 0, -f * x, -f * x * arm.y(), f * (arm.z() + x * arm.x()), -f * arm.y(), 0, 0,  //
      0, f, -f * y, -f * (arm.z() + y * arm.y()), f * y * arm.x(), f * arm.x(), 0, 0;
  return derivative;
}

void BoardGeometry::Add(const Parameters& step) {
  if (has_pose_) {
    camera_from_board_.translation += step.head<3>();
    camera_from_board_.rotation = (RotationFromVector(step.segment<3>(3)) * camera_from_board_.rotation).normalized();
    UpdateHomography();
    return;
  }
  for (int i = 0; i < 8; ++i) plane_from_board_(i / 3, i % 3) += step[i];
}

RigidTransform CameraFromMarker(const RigidTransform& camera_from_board) {
  // Half a turn about x.
  return {(camera_from_board.rotation * Eigen::Quaterniond(0, 1, 0, 0)).normalized(), camera_from_board.translation};
}

}  // namespace chequer
