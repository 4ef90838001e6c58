#include "robot/body_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/robot_pose.h"
#include "detect/toolbox.h"

namespace chequer {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
/// Directions in which a body may move, of (x, y, z, θx, θy, θz) in the camera frame: all six, or the floor's three.
using Directions = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;
using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 6, 1>;

constexpr int kMaxSteps = 20;
/// A step that explains so little more, as a share of what is unexplained plus one, ends the descent.
constexpr double kSettled = 1e-9;
/// Nearer markers are none: the derivatives would not be finite.
constexpr double kLeastDepthM = 1e-6;

/// The normal equations of a body's pose.
struct Equations {
  Matrix6d normal = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  double chi_square = 0;
  /// Of the gradient by what each print may be off: Σ over the boards of its columns times themselves transposed.
  Matrix6d of_prints = Matrix6d::Zero();
  /// Of the gradient by what the camera's calibration may be off: all boards move with the same errors.
  Eigen::Matrix<double, 6, 9> of_camera = Eigen::Matrix<double, 6, 9>::Zero();
  /// The same as if each board had a calibration of its own, as `normal` has it.
  Matrix6d of_own_cameras = Matrix6d::Zero();
};

/// Half a turn about x, both ways.
RigidTransform MarkerFromBoard() { return {Eigen::Quaterniond(0, 1, 0, 0), Eigen::Vector3d::Zero()}; }

/// How a marker's centre and rotation move when its body does: a turn θ of the body moves the centre by θ × arm.
Matrix6d MarkerByBody(const Eigen::Vector3d& arm) {
  Matrix6d by_body = Matrix6d::Identity();
  by_body.topRightCorner<3, 3>() << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0;
  return by_body;
}

Equations Linearize(std::span<const MountedBoard> boards, const RigidTransform& camera_from_body) {
  Equations equations;
  for (const MountedBoard& mounted : boards) {
    const RigidTransform camera_from_board = camera_from_body * mounted.body_from_marker * MarkerFromBoard();
    if (!(camera_from_board.translation.z() > kLeastDepthM)) {
      equations.chi_square = std::numeric_limits<double>::infinity();
      return equations;
    }
    HomographyByPose by_marker;
    const BoardMeasurement& board = mounted.board;
    const BoardGeometry::Parameters expected =
        HomographyOfPose(camera_from_board, {board.cell_m, board.cell_height_m}, board.focal_px, &by_marker);
    const BoardGeometry::Parameters residual = BoardGeometry(board.plane_from_board).parameters() - expected;
    const HomographyByPose by_body =
        by_marker * MarkerByBody(camera_from_board.translation - camera_from_body.translation);
    const HomographyByPose weighted = board.information * by_body;
    equations.normal += by_body.transpose() * weighted;
    equations.gradient += weighted.transpose() * residual;
    const Eigen::Matrix<double, 6, 4> by_print = weighted.transpose() * board.by_print;
    equations.of_prints += by_print * by_print.transpose();
    const Eigen::Matrix<double, 6, 9> by_camera = weighted.transpose() * board.by_camera;
    equations.of_camera += by_camera;
    equations.of_own_cameras += by_camera * by_camera.transpose();
    equations.chi_square += residual.dot(board.information * residual);
  }
  return equations;
}

struct Descended {
  RigidTransform camera_from_body;
  Equations equations;
};

/// Levenberg and Marquardt's descent along some directions; nothing where no pose on the way can be seen.
std::optional<Descended> Descend(std::span<const MountedBoard> boards, RigidTransform pose,
                                 const Directions& directions) {
  std::optional<Descended> best;
  double damping = 0;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Equations equations = Linearize(boards, pose);
    if (!best || equations.chi_square < best->equations.chi_square) {
      if (!std::isfinite(equations.chi_square)) return std::nullopt;
      const bool settled =
          best && best->equations.chi_square - equations.chi_square < kSettled * (equations.chi_square + 1);
      best = Descended{pose, equations};
      if (settled) break;
      damping /= 10;
    } else {
      // Back to the best pose, with a shorter step.
      damping = std::max(10 * damping, 1e-3);
      if (damping > 1e6) break;
    }
    Square damped = directions.transpose() * best->equations.normal * directions;
    damped.diagonal() *= 1 + damping;
    const Column along = damped.llt().solve(Column(directions.transpose() * best->equations.gradient));
    const Vector6d move = directions * along;
    if (!move.allFinite()) return std::nullopt;
    pose.translation = best->camera_from_body.translation + move.head<3>();
    pose.rotation = (RotationFromVector(move.tail<3>()) * best->camera_from_body.rotation).normalized();
  }
  return best;
}

/// A covariance, and the part of it that is the same in all frames.
struct Covariances {
  Square all = Square();
  Square constant = Square();
};

/// With the weights of `normal`, whose boards have calibrations of their own; then the errors of the one that they
/// have.
Covariances CovariancesAlong(const Equations& equations, const Directions& directions) {
  const Square normal = directions.transpose() * equations.normal * directions;
  const Square inverse = normal.llt().solve(Square::Identity(normal.rows(), normal.cols()));
  const Matrix6d of_camera = equations.of_camera * equations.of_camera.transpose();
  const auto along = [&](const Matrix6d& of_gradient) -> Square {
    return inverse * (directions.transpose() * of_gradient * directions) * inverse;
  };
  return {inverse + along(of_camera - equations.of_own_cameras), along(equations.of_prints + of_camera)};
}

}  // namespace

double ChiSquare(std::span<const MountedBoard> boards, const RigidTransform& camera_from_body) {
  return Linearize(boards, camera_from_body).chi_square;
}

std::optional<BodyFit> FitFreeBody(std::span<const MountedBoard> boards, const RigidTransform& camera_from_body) {
  const Directions all = Directions::Identity(6, 6);
  const auto found = Descend(boards, camera_from_body, all);
  if (!found) return std::nullopt;
  const Covariances covariances = CovariancesAlong(found->equations, all);
  BodyFit fit{found->camera_from_body, covariances.all, found->equations.chi_square};
  fit.print_covariance = covariances.constant;
  if (!fit.covariance.allFinite()) return std::nullopt;
  return fit;
}

std::optional<FloorFit> FitBodyOnFloor(std::span<const MountedBoard> boards, const RigidTransform& camera_from_world,
                                       double height_m, const RigidTransform& world_from_body) {
  const Eigen::Matrix3d axes = camera_from_world.rotation.toRotationMatrix();  // the world's, in the camera frame
  Directions on_floor = Directions::Zero(6, 3);
  on_floor.block<3, 2>(0, 0) = axes.leftCols<2>();
  on_floor.block<3, 1>(3, 2) = axes.col(2);
  const double heading = HeadingRad(world_from_body.rotation);
  const RigidTransform upright{RotationFromVector({0, 0, heading}),
                               {world_from_body.translation.x(), world_from_body.translation.y(), height_m}};
  const auto found = Descend(boards, camera_from_world * upright, on_floor);
  if (!found) return std::nullopt;
  const RigidTransform settled = camera_from_world.Inverse() * found->camera_from_body;
  const Covariances covariances = CovariancesAlong(found->equations, on_floor);
  FloorFit fit{settled.translation.head<2>(), HeadingRad(settled.rotation), covariances.all,
               found->equations.chi_square};
  fit.print_covariance = covariances.constant;
  if (!fit.covariance.allFinite()) return std::nullopt;
  return fit;
}

}  // namespace chequer
