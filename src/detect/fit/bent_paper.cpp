#include "detect/fit/bent_paper.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace chequer {
namespace {

constexpr int kMoves = BoardGeometry::kParameters, kBends = 3;
/// What is known of paper before the image is looked at, standard deviations of q, 1 / cells: a board of 6 cells lies on a
/// cylinder of a radius of 30 cells, and does not bend across that.
constexpr double kBendKnownTo = 1.0 / 60, kAcrossKnownTo = 1.0 / 3000;

constexpr int kTimesFound = 2;
/// A board that is seen from so nearly above (the tangent of its tilt) looks the same bent one way and tilted one way, or
/// both the other way: its bend is not to be told from that.
constexpr double kLeastSlant = 0.15;
/// The mean square of the distance from a corner of the pixels along one of its edges, which reach half a cell to either
/// side: they tell of that coordinate that the edge is square to.
constexpr double kAlongEdge = 1.0 / 12;

using ByBend = Eigen::Matrix<double, 2, kBends>;
using ByMoves = Eigen::Matrix<double, 2, kMoves>;

Eigen::Matrix3d SightFromBoard(const BoardGeometry& flat, double focal) {
  return Eigen::Vector3d(1 / focal, 1 / focal, 1).asDiagonal() * flat.plane_from_board();
}

/// How the board's coordinates of a point that is seen move as it leaves the board's plane, cells a cell.
Eigen::Vector2d BoardByHeight(const BoardGeometry& flat, double focal, const Eigen::Vector2d& board) {
  const Eigen::Matrix3d sight_from_board = SightFromBoard(flat, focal);
  const Eigen::Vector3d x = sight_from_board.col(0), y = sight_from_board.col(1);
  const Eigen::Vector3d up = x.cross(y) / std::sqrt(x.norm() * y.norm());
  const Eigen::Vector3d at = sight_from_board * board.homogeneous();
  const Eigen::Vector2d plane_by_height = focal * (up.head<2>() - at.head<2>() / at.z() * up.z()) / at.z();
  return flat.PlaneByBoard(board).inverse() * plane_by_height;
}

Eigen::Vector3d SquaresOf(const Eigen::Vector2d& board) {
  return {board.x() * board.x(), board.x() * board.y(), board.y() * board.y()};
}

/// The direction of the strongest bend, and how strong it is there: 1 / radius.
struct Cylinder {
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();
  double curvature = 0;

  explicit Cylinder(const Eigen::Vector3d& bend) {
    const Eigen::Matrix2d square = (Eigen::Matrix2d() << bend[0], bend[1] / 2, bend[1] / 2, bend[2]).finished();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(square);
    Eigen::Index most;
    axes.eigenvalues().cwiseAbs().maxCoeff(&most);
    direction = axes.eigenvectors().col(most);
    curvature = 2 * axes.eigenvalues()[most];
  }
  /// By which a way along the bend is shorter than the paper: t − sin(κ t) / κ.
  Eigen::Vector2d Shortened(const Eigen::Vector2d& board) const {
    const double way = direction.dot(board);
    return curvature * curvature * way * way * way / 6 * direction;
  }
};

/// Least squares of what the corners are off. @param roughly the bend, if it is known: how much shorter the paper reaches,
/// and along which direction it bends, hang on it.
std::optional<BentPaper> SolveBend(const BoardGeometry& flat, double focal, std::span<const CornerOff> corners,
                                   const std::optional<Cylinder>& roughly) {
  Eigen::Matrix<double, kMoves, kMoves> of_moves = Eigen::Matrix<double, kMoves, kMoves>::Zero();
  Eigen::Matrix<double, kMoves, kBends> common = Eigen::Matrix<double, kMoves, kBends>::Zero();
  Eigen::Matrix3d of_bend = Eigen::Matrix3d::Zero();
  BoardGeometry::Parameters moves_gradient = BoardGeometry::Parameters::Zero();
  Eigen::Vector3d bend_gradient = Eigen::Vector3d::Zero();
  double without = 0;
  for (const CornerOff& corner : corners) {
    const Eigen::Vector2d& at = corner.board;
    ByMoves by_moves;
    for (int axis = 0; axis < 2; ++axis) by_moves.row(axis) = BoardGeometry::MoveByParameters(at, axis).transpose();
    // A pixel that shows a point which the bend moved that way has coordinates that are off the other way.
    const Eigen::Vector2d by_height = BoardByHeight(flat, focal, at);
    ByBend by_bend;
    for (int axis = 0; axis < 2; ++axis)
      by_bend.row(axis) = -by_height[axis] * (SquaresOf(at) + kAlongEdge * Eigen::Vector3d(axis, 0, 1 - axis)).transpose();
    Eigen::Vector2d off = corner.shift - corner.bent;
    if (roughly) off -= roughly->Shortened(at);
    const Eigen::Vector2d pull = corner.information * off;
    of_moves += by_moves.transpose() * corner.information * by_moves;
    common += by_moves.transpose() * corner.information * by_bend;
    of_bend += by_bend.transpose() * corner.information * by_bend;
    moves_gradient += by_moves.transpose() * pull;
    bend_gradient += by_bend.transpose() * pull;
    without += off.dot(pull);
  }
  const Eigen::LDLT<Eigen::Matrix<double, kMoves, kMoves>> factor(of_moves);
  if (factor.info() != Eigen::Success || !factor.isPositive()) return std::nullopt;
  // The moves follow the bend.
  const Eigen::Matrix<double, kMoves, kBends> followed = factor.solve(common);
  const BoardGeometry::Parameters flat_moves = factor.solve(moves_gradient);
  Eigen::Matrix3d information = of_bend - common.transpose() * followed;
  information.diagonal().array() += 1 / (kBendKnownTo * kBendKnownTo);
  if (roughly) {
    const Eigen::Vector3d across = SquaresOf(roughly->direction.unitOrthogonal()) / kAcrossKnownTo;
    information += across * across.transpose();
  }
  const Eigen::LLT<Eigen::Matrix3d> bends(information);
  if (bends.info() != Eigen::Success) return std::nullopt;
  const Eigen::Vector3d gradient = bend_gradient - followed.transpose() * moves_gradient;
  BentPaper paper;
  paper.bend = bends.solve(gradient);
  paper.moves = flat_moves - followed * paper.bend;
  const Eigen::Matrix3d root = bends.matrixL().solve(Eigen::Matrix3d::Identity());
  paper.uncertain = followed * root.transpose();
  paper.gain = gradient.dot(paper.bend);
  paper.left = without - moves_gradient.dot(flat_moves) - paper.gain;
  if (!paper.moves.allFinite() || !paper.uncertain.allFinite()) return std::nullopt;
  return paper;
}

}  // namespace

Eigen::Vector2d BentPaper::BentAt(const BoardGeometry& flat, double focal, const Eigen::Vector2d& board) const {
  return BoardByHeight(flat, focal, board) * bend.dot(SquaresOf(board)) - Cylinder(bend).Shortened(board);
}

std::optional<BentPaper> FindBentPaper(const BoardGeometry& flat, double focal, std::span<const CornerOff> corners) {
  if (!(BoardByHeight(flat, focal, {0, 0}).norm() > kLeastSlant)) return std::nullopt;
  std::optional<BentPaper> paper = SolveBend(flat, focal, corners, std::nullopt);
  for (int i = 0; i < kTimesFound && paper; ++i) paper = SolveBend(flat, focal, corners, Cylinder(paper->bend));
  return paper;
}

}  // namespace chequer
