#include "detect/plane_pose.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "detect/small_cholesky.h"

namespace chequer {
namespace {

using Parameters = BoardGeometry::Parameters;
using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr int kMaxSteps = 12;
/// A step that will explain so little more, as a share of what is unexplained plus one, ends the descent: it moves the
/// pose by a hundredth of its standard deviation.
constexpr double kSettled = 1e-4;

/// The homography of a pose: focal · cell · [r₁ r₂ t/cell] over its last entry t_z; and its derivative.
struct PosedHomography {
  PosedHomography(const RigidTransform& pose, double cell_m, double focal)
      : inverse_depth(1 / pose.translation.z()), scale(focal * inverse_depth, focal * inverse_depth, inverse_depth) {
    const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
    for (int col = 0; col < 2; ++col) {
      side[col] = cell_m * rotation.col(col);
      Set(col, scale.cwiseProduct(side[col]), h);
    }
    for (int row = 0; row < 2; ++row) h[3 * row + 2] = scale[row] * pose.translation[row];
  }

  /// How the parameters move with x, y, z, θx, θy or θz. A small turn θ moves a side r by θ × r.
  Parameters By(int of_pose) const {
    if (of_pose == 2) return -inverse_depth * h;
    Parameters by = Parameters::Zero();
    if (of_pose < 2)
      by[3 * of_pose + 2] = scale[of_pose];
    else
      for (int col = 0; col < 2; ++col)
        Set(col, scale.cwiseProduct(Eigen::Vector3d::Unit(of_pose - 3).cross(side[col])), by);
    return by;
  }
  /// The derivative's transpose times a vector.
  Vector6d Back(const Parameters& v) const {
    Vector6d back;
    back << scale[0] * v[2], scale[1] * v[5], -inverse_depth * h.dot(v), 0, 0, 0;
    for (int col = 0; col < 2; ++col)
      back.tail<3>() += side[col].cross(scale.cwiseProduct(Eigen::Vector3d(v[col], v[3 + col], v[6 + col])));
    return back;
  }

  double inverse_depth;
  Eigen::Vector3d scale, side[2];
  Parameters h;

 private:
  static void Set(int col, const Eigen::Vector3d& values, Parameters& of) {
    for (int row = 0; row < 3; ++row) of[3 * row + col] = values[row];
  }
};

/// Levenberg and Marquardt's descent.
class Descent {
 public:
  /// The pose's χ² is infinite if the board came behind the camera.
  Descent(RigidTransform pose, const MeasuredHomography& measured, double cell_m, double focal)
      : pose_{pose, Matrix6d::Identity(), std::numeric_limits<double>::infinity()} {
    const Parameters target = measured.geometry.parameters();
    Vector6d gradient;
    double damping = 0;
    for (int step = 0; step < kMaxSteps; ++step) {
      if (!(pose.translation.z() > 1e-9)) break;
      const PosedHomography at(pose, cell_m, focal);
      const Parameters residual = target - at.h, weighted = measured.information.lazyProduct(residual);
      const double chi_square = residual.dot(weighted);
      if (chi_square < pose_.chi_square) {
        for (int k = 0; k < 6; ++k)
          normal_.col(k) = at.Back(k < 2 ? at.scale[k] * measured.information.col(3 * k + 2)
                                         : Parameters(measured.information.lazyProduct(at.By(k))));
        gradient = at.Back(weighted);
        pose_.camera_from_board = pose;
        pose_.chi_square = chi_square;
        damping /= 10;
      } else {
        // Back to the best pose, with a shorter step.
        damping = std::max(10 * damping, 1e-3);
        if (damping > 1e3) break;
      }
      Matrix6d damped = normal_;
      damped.diagonal() *= 1 + damping;
      const Vector6d move = SmallCholesky<6>(damped).Solve(gradient);
      if (!move.allFinite()) break;
      pose.translation = pose_.camera_from_board.translation + move.head<3>();
      pose.rotation = (RotationFromVector(move.tail<3>()) * pose_.camera_from_board.rotation).normalized();
      const double gain = gradient.dot(move);
      if (gain >= kSettled * (pose_.chi_square + 1)) continue;
      pose_.camera_from_board = pose;
      pose_.chi_square -= gain;
      break;
    }
  }

  /// Without its covariance.
  const PlanePose& pose() const { return pose_; }
  Matrix6d Covariance() const { return SmallCholesky<6>(normal_).Inverse(); }

 private:
  PlanePose pose_;
  Matrix6d normal_ = Matrix6d::Identity();
};

}  // namespace

Parameters HomographyOfPose(const RigidTransform& camera_from_board, double cell_m, double focal,
                            HomographyByPose* by_pose) {
  const PosedHomography at(camera_from_board, cell_m, focal);
  for (int k = 0; k < 6; ++k) by_pose->col(k) = at.By(k);
  return at.h;
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
  const auto descend = [&](double sign) {
    Eigen::Matrix3d rotation;
    rotation.col(0) << r(0, 0), r(1, 0), sign * b0;
    rotation.col(1) << r(0, 1), r(1, 1), sign * b1;
    rotation.col(2) = rotation.col(0).cross(rotation.col(1));
    const RigidTransform start{Eigen::Quaterniond(Eigen::Matrix3d(to_sight * rotation)).normalized(), translation};
    return Descent(start, measured, cell_m, focal);
  };
  const std::array<Descent, 2> descents{descend(1), descend(-1)};
  const std::size_t better = descents[1].pose().chi_square < descents[0].pose().chi_square ? 1 : 0;
  if (!std::isfinite(descents[better].pose().chi_square)) return std::nullopt;
  std::array<PlanePose, 2> poses{descents[better].pose(), descents[1 - better].pose()};
  poses[0].covariance = descents[better].Covariance();
  return poses;
}

}  // namespace chequer
