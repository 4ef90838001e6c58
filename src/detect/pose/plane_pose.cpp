#include "detect/pose/plane_pose.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/rotations.h"
#include "core/small_cholesky.h"

namespace chequer {
namespace {

using Parameters = BoardGeometry::Parameters;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Steps at most (a guess).
constexpr int kMaxSteps = 12;
/// The descent ends with a step that reduces the unexplained part by less than this share of itself plus one. Such a
/// step moves the pose by a hundredth of its standard deviation.
constexpr double kSettledGain = 1e-4;
/// A pose whose first step promises a χ² larger by this is not refined: if both were equally likely before, it has a
/// probability of e^−500.
constexpr double kMuchWorse = 1000;

/// The homography of a pose: focal · [w r₁ h r₂ t] of cells w × h over its last entry t_z; and its derivative.
struct PosedHomography {
  PosedHomography(const RigidTransform& pose, const Eigen::Vector2d& cell_m, double focal)
      : inverse_depth(1 / pose.translation.z()), scale(focal * inverse_depth, focal * inverse_depth, inverse_depth) {
    const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
    for (int col = 0; col < 2; ++col) {
      side[col] = cell_m[col] * rotation.col(col);
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
  /// Information times By(of_pose), of two coordinates of the place or a turn: those move three parameters or fewer a
  /// column.
  Parameters WeightedBy(int of_pose, const BoardGeometry::Information& information) const {
    if (of_pose < 2) return scale[of_pose] * information.col(3 * of_pose + 2);
    const int axis = of_pose - 3, first = (axis + 1) % 3, second = (axis + 2) % 3;
    Parameters weighted = Parameters::Zero();
    for (int col = 0; col < 2; ++col)
      weighted += scale[second] * side[col][first] * information.col(3 * second + col) -
                  scale[first] * side[col][second] * information.col(3 * first + col);
    return weighted;
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
  Eigen::Vector3d scale = Eigen::Vector3d::Zero();
  Eigen::Vector3d side[2] = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  Parameters h = Parameters::Zero();

 private:
  static void Set(int col, const Eigen::Vector3d& values, Parameters& of) {
    for (int row = 0; row < 3; ++row) of[3 * row + col] = values[row];
  }
};

/// Levenberg and Marquardt's descent.
class Descent {
 public:
  Descent(const RigidTransform& start, const MeasuredHomography& measured, const Eigen::Vector2d& cell_m, double focal)
      : measured_(measured),
        target_(measured.geometry.parameters()),
        weighted_target_(measured.information.lazyProduct(target_)),
        cell_m_(cell_m),
        focal_(focal),
        next_(start) {}

  /// Goes on until it settles, for kMaxSteps at most. The pose's χ² stays infinite if the board comes behind the camera
  /// at once.
  void Run() {
    while (!done_) Step();
  }
  void Step() {
    done_ = ++steps_ >= kMaxSteps || !(next_.translation.z() > 1e-9) || !Look();
    if (done_) return;
    Matrix6d damped = normal_;
    damped.diagonal() *= 1 + damping_;
    const Vector6d move = SmallCholesky<6>(damped).Solve(gradient_);
    done_ = !move.allFinite();
    if (done_) return;
    next_.translation = pose_.camera_from_board.translation + move.head<3>();
    next_.rotation = (RotationFromVector(move.tail<3>()) * pose_.camera_from_board.rotation).normalized();
    const double before = std::exchange(gain_, gradient_.dot(move));
    // Near the end, errors are squared from step to step, and the gain is the square of an error.
    const double after = damping_ == 0 && gain_ < before ? gain_ * (gain_ / before) * (gain_ / before) : gain_;
    done_ = after < kSettledGain * (pose_.chi_square - gain_ + 1);
    if (done_) TakeNext();
  }
  /// Takes the next step's pose, and what that step promised, without looking.
  void TakeNext() {
    pose_.camera_from_board = next_;
    pose_.chi_square -= gain_;
  }
  /// What the next step promises: where errors are small, the minimum to a hundredth.
  double promised_chi_square() const { return pose_.chi_square - gain_; }

  /// Without its covariance.
  const PlanePose& pose() const { return pose_; }
  Matrix6d Covariance() const { return SmallCholesky<6>(normal_).Inverse(); }

 private:
  /// Takes the next pose if it is better; else the next step will be shorter. False if it would be too short.
  bool Look() {
    const PosedHomography at(next_, cell_m_, focal_);
    const Parameters residual = target_ - at.h, weighted = measured_.information.lazyProduct(residual);
    const double chi_square = residual.dot(weighted);
    if (!(chi_square < pose_.chi_square)) {
      damping_ = std::max(10 * damping_, 1e-3);
      return damping_ <= 1e3;
    }
    for (int k = 0; k < 6; ++k)
      normal_.col(k) =
          at.Back(k == 2 ? at.inverse_depth * (weighted - weighted_target_) : at.WeightedBy(k, measured_.information));
    gradient_ = at.Back(weighted);
    pose_.camera_from_board = next_;
    pose_.chi_square = chi_square;
    damping_ /= 10;
    return true;
  }

  const MeasuredHomography& measured_;
  Parameters target_ = Parameters::Zero(), weighted_target_ = Parameters::Zero();
  Eigen::Vector2d cell_m_ = Eigen::Vector2d::Zero();
  double focal_;
  RigidTransform next_;
  PlanePose pose_{{}, Matrix6d::Identity(), std::numeric_limits<double>::infinity()};  ///< the best by now
  Matrix6d normal_ = Matrix6d::Identity();
  Vector6d gradient_ = Vector6d::Zero();
  double damping_ = 0, gain_ = 0;
  int steps_ = 0;
  bool done_ = false;
};

}  // namespace

Parameters HomographyOfPose(const RigidTransform& camera_from_board, const Eigen::Vector2d& cell_m, double focal,
                            HomographyByPose* by_pose) {
  const PosedHomography at(camera_from_board, cell_m, focal);
  for (int k = 0; k < 6; ++k) by_pose->col(k) = at.By(k);
  return at.h;
}

std::optional<std::array<RigidTransform, 2>> PosesAtCentre(const BoardGeometry& geometry, const Eigen::Vector2d& cell_m,
                                                           double focal) {
  const Eigen::Matrix3d& h = geometry.plane_from_board();
  // First-order behaviour of the homography at the board's origin, on the plane z = 1.
  const Eigen::Vector2d p = h.block<2, 1>(0, 2) / focal;
  Eigen::Matrix2d jacobian = geometry.PlaneByBoard({0, 0}) / focal;
  jacobian.col(1) *= cell_m.x() / cell_m.y();  // by squares of a cell's width
  if (!jacobian.allFinite() || !(jacobian.determinant() > 0)) return std::nullopt;
  // A camera that looks straight at the point sees the board by a 2 × 2 matrix A = γ R₂₂ (IPPE, section 3.2).
  const Eigen::Matrix3d to_sight =
      RotationBetween(Eigen::Vector3d::UnitZ(), Eigen::Vector3d(p.x(), p.y(), 1)).toRotationMatrix();
  const Eigen::Matrix2d b = to_sight.topLeftCorner<2, 2>() - p * to_sight.block<1, 2>(2, 0);
  const Eigen::Matrix2d a = b.inverse() * jacobian;
  const double trace = a.squaredNorm(), determinant = a.determinant();
  const double gamma =
      std::sqrt(0.5 * (trace + std::sqrt(std::max(trace * trace - 4 * determinant * determinant, 0.0))));
  const Eigen::Matrix2d r = a / gamma;
  const double b0 = std::sqrt(std::max(1 - r.col(0).squaredNorm(), 0.0));
  double b1 = std::sqrt(std::max(1 - r.col(1).squaredNorm(), 0.0));
  if (-r.col(0).dot(r.col(1)) < 0) b1 = -b1;
  // γ is the width of a cell over the distance along the line of sight.
  const Eigen::Vector3d translation = cell_m.x() / gamma * Eigen::Vector3d(p.x(), p.y(), 1).normalized();
  const auto pose = [&](double sign) {
    Eigen::Matrix3d rotation;
    rotation.col(0) << r(0, 0), r(1, 0), sign * b0;
    rotation.col(1) << r(0, 1), r(1, 1), sign * b1;
    rotation.col(2) = rotation.col(0).cross(rotation.col(1));
    return RigidTransform{Eigen::Quaterniond(Eigen::Matrix3d(to_sight * rotation)).normalized(), translation};
  };
  return std::array<RigidTransform, 2>{pose(1), pose(-1)};
}

std::optional<std::array<PlanePose, 2>> PlanePoses(const MeasuredHomography& measured, const Eigen::Vector2d& cell_m,
                                                   double focal) {
  const std::optional<std::array<RigidTransform, 2>> starts = PosesAtCentre(measured.geometry, cell_m, focal);
  if (!starts) return std::nullopt;
  std::array<Descent, 2> descents{Descent((*starts)[0], measured, cell_m, focal),
                                  Descent((*starts)[1], measured, cell_m, focal)};
  for (Descent& descent : descents) descent.Step();
  std::size_t better = descents[1].promised_chi_square() < descents[0].promised_chi_square() ? 1 : 0;
  descents[better].Run();
  Descent& other = descents[1 - better];
  if (other.promised_chi_square() - descents[better].pose().chi_square > kMuchWorse)
    other.TakeNext();
  else
    other.Run();
  if (other.pose().chi_square < descents[better].pose().chi_square) better = 1 - better;
  if (!std::isfinite(descents[better].pose().chi_square)) return std::nullopt;
  std::array<PlanePose, 2> poses{descents[better].pose(), descents[1 - better].pose()};
  poses[0].covariance = descents[better].Covariance();
  return poses;
}

}  // namespace chequer
