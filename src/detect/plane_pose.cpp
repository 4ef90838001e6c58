#include "detect/plane_pose.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// The translation that explains the pairs best for a given rotation: linear least squares.
Eigen::Vector3d BestTranslation(const Eigen::Matrix3d& rotation, std::span<const PointPair> pairs) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const PointPair& pair : pairs) {
    const Eigen::Vector3d arm = rotation.leftCols<2>() * pair.from;
    Eigen::Matrix<double, 2, 3> row;
    row << 1, 0, -pair.to.x(), 0, 1, -pair.to.y();
    const Eigen::Vector2d value = pair.to * arm.z() - arm.head<2>();
    normal += row.transpose() * row;
    right += row.transpose() * value;
  }
  return normal.ldlt().solve(right);
}

PlanePose Refine(RigidTransform pose, std::span<const PointPair> pairs) {
  PlanePose best{pose, 1e300};
  double damping = 1e-6;
  for (int iteration = 0; iteration < 12; ++iteration) {
    Matrix6d normal = Matrix6d::Zero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    double square = 0;
    const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
    bool behind = false;
    for (const PointPair& pair : pairs) {
      const Eigen::Vector3d arm = rotation.leftCols<2>() * pair.from;
      const Eigen::Vector3d p = arm + pose.translation;
      if (!(p.z() > 1e-9)) {
        behind = true;
        break;
      }
      const double w = 1 / p.z(), x = p.x() * w, y = p.y() * w;
      Eigen::Matrix<double, 2, 6> row;
      row << w, 0, -w * x, -w * x * arm.y(), w * (arm.z() + x * arm.x()), -w * arm.y(),  //
          0, w, -w * y, -w * (arm.z() + y * arm.y()), w * y * arm.x(), w * arm.x();
      const Eigen::Vector2d residual = pair.to - Eigen::Vector2d(x, y);
      normal.noalias() += row.transpose() * row;
      right.noalias() += row.transpose() * residual;
      square += residual.squaredNorm();
    }
    if (behind || square > best.square_error) {
      // Back to the best pose, with a shorter step.
      damping *= 100;
      if (damping > 1e3 || best.square_error > 1e299) break;
      pose = best.camera_from_board;
      continue;
    }
    const bool settled = best.square_error - square < 1e-6 * square;
    best = {pose, square};
    if (settled) break;
    Matrix6d damped = normal;
    damped.diagonal() *= 1 + damping;
    const Eigen::Matrix<double, 6, 1> step = damped.ldlt().solve(right);
    if (!step.allFinite()) break;
    damping = std::max(damping / 10, 1e-9);
    pose.translation += step.head<3>();
    pose.rotation = (RotationFromVector(step.tail<3>()) * pose.rotation).normalized();
  }
  return best;
}

}  // namespace

std::optional<std::array<PlanePose, 2>> PlanePoses(const Eigen::Matrix3d& normalized_from_board,
                                                   std::span<const PointPair> pairs) {
  const Eigen::Matrix3d h = normalized_from_board / normalized_from_board(2, 2);
  // First-order behaviour of the homography at the board's origin.
  const Eigen::Vector2d p(h(0, 2), h(1, 2));
  Eigen::Matrix2d jacobian;
  jacobian << h(0, 0) - h(2, 0) * p.x(), h(0, 1) - h(2, 1) * p.x(),  //
      h(1, 0) - h(2, 0) * p.y(), h(1, 1) - h(2, 1) * p.y();
  if (!jacobian.allFinite() || !(jacobian.determinant() > 0)) return std::nullopt;
  // A camera that looks straight at the point sees the board by a 2 × 2 matrix A = γ R₂₂ (IPPE, section 3.2).
  const Eigen::Matrix3d to_sight =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), Eigen::Vector3d(p.x(), p.y(), 1)).toRotationMatrix();
  Eigen::Matrix2d b;
  b << to_sight(0, 0) - p.x() * to_sight(2, 0), to_sight(0, 1) - p.x() * to_sight(2, 1),  //
      to_sight(1, 0) - p.y() * to_sight(2, 0), to_sight(1, 1) - p.y() * to_sight(2, 1);
  const Eigen::Matrix2d a = b.inverse() * jacobian;
  const double trace = a.squaredNorm(), determinant = a.determinant();
  const double gamma =
      std::sqrt(0.5 * (trace + std::sqrt(std::max(trace * trace - 4 * determinant * determinant, 0.0))));
  const Eigen::Matrix2d r = a / gamma;
  double b0 = std::sqrt(std::max(1 - r.col(0).squaredNorm(), 0.0));
  double b1 = std::sqrt(std::max(1 - r.col(1).squaredNorm(), 0.0));
  if (-r.col(0).dot(r.col(1)) < 0) b1 = -b1;
  std::array<PlanePose, 2> poses;
  for (std::size_t i = 0; i < 2; ++i) {
    const double sign = i == 0 ? 1 : -1;
    Eigen::Matrix3d rotation;
    rotation.col(0) << r(0, 0), r(1, 0), sign * b0;
    rotation.col(1) << r(0, 1), r(1, 1), sign * b1;
    rotation.col(2) = rotation.col(0).cross(rotation.col(1));
    rotation = to_sight * rotation;
    const RigidTransform start{Eigen::Quaterniond(rotation).normalized(), BestTranslation(rotation, pairs)};
    if (!start.translation.allFinite() || !(start.translation.z() > 0)) return std::nullopt;
    poses[i] = Refine(start, pairs);
  }
  if (poses[1].square_error < poses[0].square_error) std::swap(poses[0], poses[1]);
  return poses;
}

PlanePose MirroredPose(const RigidTransform& camera_from_board, std::span<const PointPair> pairs) {
  const Eigen::Vector3d sight = camera_from_board.translation.normalized();
  const Eigen::Vector3d normal = camera_from_board.rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d mirrored = 2 * normal.dot(sight) * sight - normal;
  RigidTransform start = camera_from_board;
  start.rotation = (Eigen::Quaterniond::FromTwoVectors(normal, mirrored) * camera_from_board.rotation).normalized();
  return Refine(start, pairs);
}

}  // namespace chequer
