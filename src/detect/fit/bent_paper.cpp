#include "detect/fit/bent_paper.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/small_cholesky.h"
#include "detect/pose/plane_pose.h"

namespace chequer {
namespace {

constexpr int kMoves = BoardGeometry::kParameters, kBends = LinearBend::kBends, kUnknowns = BentPaper::kUnknowns;
/// A cylinder does not bend across its bend: how far that is known, as kBendKnownTo.
constexpr double kAcrossKnownTo = 1.0 / 3000;
/// Flat boards are not asked any further where a homography and a bend, found in one linear step, gain less than that
/// share of what they have to: bends that gain just as much are so weak that both gain alike.
constexpr double kRoughly = 0.8;
/// The same by what the bend leaves: as a flat board's pose leaves more than a homography does, bends gain more over it
/// than in that step (measured: the step had .23 of what they had to gain at least, of 440 bends that were found, of
/// radii of .15 to 4 m; half of the boards of demosaiced images that were searched in vain had less).
constexpr double kRoughlyOfLeft = 0.2;
/// Steps before which a bend has no direction yet along which it could be a cylinder's.
constexpr int kStepsWithoutDirection = 2;
constexpr int kMostSteps = 25;
/// A step that will explain so little more, as a share of what is unexplained plus one, is the last.
constexpr double kSettled = 1e-4;

/// The direction of the strongest bend, and how strong it is there: 1 / radius.
struct Cylinder {
  Eigen::Vector2d direction = Eigen::Vector2d::UnitX();
  double curvature = 0;
  double across = 0;  ///< what bends across it: that entry of q

  explicit Cylinder(const Eigen::Vector3d& bend) {
    const Eigen::Matrix2d square = (Eigen::Matrix2d() << bend[0], bend[1] / 2, bend[1] / 2, bend[2]).finished();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
    axes.computeDirect(square);
    Eigen::Index most;
    axes.eigenvalues().cwiseAbs().maxCoeff(&most);
    direction = axes.eigenvectors().col(most);
    curvature = 2 * axes.eigenvalues()[most];
    across = axes.eigenvalues()[1 - most];
  }
  /// How `across` moves with q.
  Eigen::Vector3d AcrossByBend() const { return SquaresOf(direction.unitOrthogonal()); }
};

/// A board of bent paper in front of a camera, in widths of a cell.
struct Lying {
  RigidTransform camera_from_board;
  Eigen::Vector3d bend = Eigen::Vector3d::Zero();
};

/// A point of the paper, from the board's middle along the camera's axes.
Eigen::Vector3d OnPaper(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& bend, const Eigen::Vector2d& direction,
                        double curvature, double cell_ratio, const Eigen::Vector2d& board) {
  // A way along the bend is shorter than the paper: by t − sin(κ t) / κ.
  const double way = direction.dot(board);
  const Eigen::Vector2d on_plane = board - curvature * curvature * way * way * way / 6 * direction;
  const double height = bend.dot(SquaresOf(board)) * std::sqrt(cell_ratio);
  return rotation * Eigen::Vector3d(on_plane.x(), on_plane.y() * cell_ratio, height);
}

BoardGeometry MiddleOf(const Lying& lying, double focal, double cell_ratio) {
  Eigen::Matrix3d h = lying.camera_from_board.rotation.toRotationMatrix();
  h.col(1) *= cell_ratio;
  h.col(2) = lying.camera_from_board.translation;
  h.topRows<2>() *= focal;
  return BoardGeometry(h);
}

}  // namespace

/// Levenberg and Marquardt's descent from one pose, and what is known at its end.
class BendSolver {
 public:
  BendSolver(const BoardView& view, std::span<const SeenCorner> corners) : view_(view), seen_(corners) {
    if (view.fitted_as) taken_out_ = view.fitted_as->bend();
  }

  /// What flat paper leaves, from that pose.
  double Flat(const RigidTransform& start) { return Descend({start, Eigen::Vector3d::Zero()}, false).square; }
  /// Nothing if the descent does not converge. TellGain() and TellUncertainty() fill in the rest.
  std::optional<BentPaper> Bent(const RigidTransform& start) {
    const End end = Descend({start, Eigen::Vector3d::Zero()}, true);
    if (!std::isfinite(end.square)) return std::nullopt;
    BentPaper paper;
    paper.camera_from_board_ = end.lying.camera_from_board;
    paper.rotation_ = end.lying.camera_from_board.rotation.toRotationMatrix();
    paper.bend_ = end.lying.bend;
    const Cylinder cylinder(paper.bend_);
    paper.direction_ = cylinder.direction;
    paper.curvature_ = cylinder.curvature;
    paper.focal_ = view_.focal;
    paper.cell_ratio_ = view_.cell_ratio;
    paper.middle_ = MiddleOf(end.lying, view_.focal, view_.cell_ratio);
    paper.left_ = end.square;
    return paper;
  }
  /// @param flat what flat paper leaves.
  static void TellGain(BentPaper& paper, double flat) { paper.gain_ = flat - paper.left_; }
  /// What the bend leaves unknown of the homography of the middle.
  bool TellUncertainty(BentPaper& paper) const {
    const Lying lying{paper.camera_from_board_, paper.bend_};
    std::optional<LinearBend> linear = Linearised(lying, paper);
    if (!linear) return false;
    const Eigen::Vector3d across = Cylinder(paper.bend_).AcrossByBend() / kAcrossKnownTo;
    linear->information += across * across.transpose();
    paper.uncertain_ = linear->UncertainMoves();
    return paper.uncertain_.allFinite();
  }

 private:
  struct End {
    Lying lying;
    double square = std::numeric_limits<double>::infinity();
  };
  using Vector = Eigen::Matrix<double, kUnknowns, 1>;
  using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;
  using ByUnknowns = Eigen::Matrix<double, 2, kUnknowns>;

  /// Where a corner is seen to lie, in the plane, and its derivative by pose and bend.
  /// @param rotation of the board, as a matrix.
  std::optional<Eigen::Vector2d> Predict(const Lying& lying, const Eigen::Matrix3d& rotation, const Cylinder& cylinder,
                                         const Eigen::Vector2d& board, ByUnknowns& by) const {
    const Eigen::Vector3d turned =
        OnPaper(rotation, lying.bend, cylinder.direction, cylinder.curvature, view_.cell_ratio, board);
    const Eigen::Vector3d at = turned + lying.camera_from_board.translation;
    if (!(at.z() > 1e-6)) return std::nullopt;
    const double scale = view_.focal / at.z();
    Eigen::Matrix<double, 2, 3> by_point;
    by_point << scale, 0, -scale * at.x() / at.z(), 0, scale, -scale * at.y() / at.z();
    by.leftCols<3>() = by_point;
    Eigen::Matrix3d by_turn;
    by_turn << 0, turned.z(), -turned.y(), -turned.z(), 0, turned.x(), turned.y(), -turned.x(), 0;
    by.middleCols<3>(3) = by_point.lazyProduct(by_turn);
    const Eigen::Vector2d by_height = by_point * rotation.col(2) * std::sqrt(view_.cell_ratio);
    by.rightCols<kBends>() = by_height * SquaresOf(board).transpose();
    // What the pixels along an edge say is of the mean along it, but for the bend that was taken out of them.
    Eigen::Matrix2d by_board;
    by_board << by_point * rotation.col(0), by_point * rotation.col(1) * view_.cell_ratio;
    const Eigen::Vector2d along = kAlongEdge * (by_board.inverse() * by_height);
    by.col(6) += along.y() * by_board.col(1);
    by.col(8) += along.x() * by_board.col(0);
    const Eigen::Vector3d left = lying.bend - taken_out_;
    const Eigen::Vector2d mean = along.x() * left[2] * by_board.col(0) + along.y() * left[0] * by_board.col(1);
    return Eigen::Vector2d(view_.focal / at.z() * at.head<2>()) + mean;
  }

  /// Σ of squares with what is known of paper; infinite where the board is not before the camera.
  double Look(const Lying& lying, bool bends, bool has_direction, Matrix& normal, Vector& gradient) const {
    normal.setZero();
    gradient.setZero();
    double square = 0;
    const Cylinder cylinder(lying.bend);
    const Eigen::Matrix3d rotation = lying.camera_from_board.rotation.toRotationMatrix();
    for (const SeenCorner& seen : seen_) {
      ByUnknowns by;
      const std::optional<Eigen::Vector2d> predicted = Predict(lying, rotation, cylinder, seen.board, by);
      if (!predicted) return std::numeric_limits<double>::infinity();
      const Eigen::Vector2d off = seen.plane - *predicted, pull = seen.information * off;
      square += off.dot(pull);
      gradient += by.transpose().lazyProduct(pull);
      const ByUnknowns weighted = seen.information.lazyProduct(by);
      normal += by.transpose().lazyProduct(weighted);
    }
    if (!bends) {
      normal.rightCols<kBends>().setZero();
      normal.bottomRows<kBends>().setZero();
      gradient.tail<kBends>().setZero();
      normal.diagonal().tail<kBends>().setOnes();
      return square;
    }
    const double known = 1 / (kBendKnownTo * kBendKnownTo);
    square += known * lying.bend.squaredNorm();
    gradient.tail<kBends>() -= known * lying.bend;
    normal.diagonal().tail<kBends>().array() += known;
    if (has_direction) {
      const Eigen::Vector3d by = cylinder.AcrossByBend() / kAcrossKnownTo;
      const double off = cylinder.across / kAcrossKnownTo;
      square += off * off;
      gradient.tail<kBends>() -= off * by;
      normal.bottomRightCorner<kBends, kBends>() += by * by.transpose();
    }
    return square;
  }

  End Descend(const Lying& start, bool bends) const {
    End best;
    best.lying = start;
    Matrix normal, at_next;
    Vector gradient, gradient_next;
    double damping = 0;
    best.square = Look(start, bends, false, normal, gradient);
    for (int step = 1; step <= kMostSteps && std::isfinite(best.square); ++step) {
      Matrix damped = normal;
      damped.diagonal() *= 1 + damping;
      const SmallCholesky<kUnknowns> factor(damped);
      if (!factor.positive()) return {};
      const Vector move = factor.Solve(gradient);
      if (!move.allFinite()) return {};
      const double gain = gradient.dot(move);
      Lying next;
      next.camera_from_board.translation = best.lying.camera_from_board.translation + move.head<3>();
      next.camera_from_board.rotation =
          (RotationFromVector(move.segment<3>(3)) * best.lying.camera_from_board.rotation).normalized();
      next.bend = best.lying.bend + move.tail<kBends>();
      const bool has_direction = step >= kStepsWithoutDirection, gets_direction = step == kStepsWithoutDirection;
      const double square = Look(next, bends, has_direction, at_next, gradient_next);
      // With the direction comes a term that the step before did not know.
      if (!(square < best.square) && !(bends && gets_direction && std::isfinite(square))) {
        damping = std::max(10 * damping, 1e-3);
        if (damping > 1e6) break;
        continue;
      }
      best = {next, square};
      normal = at_next;
      gradient = gradient_next;
      damping /= 10;
      if (step > kStepsWithoutDirection && gain < kSettled * (square + 1)) break;
    }
    return best;
  }

  std::optional<LinearBend> Linearised(const Lying& lying, const BentPaper& paper) const {
    LinearBend::Products products = LinearBend::Products::Zero();
    const Cylinder cylinder(lying.bend);
    const Eigen::Matrix3d rotation = lying.camera_from_board.rotation.toRotationMatrix();
    for (const SeenCorner& seen : seen_) {
      ByUnknowns by;
      if (!Predict(lying, rotation, cylinder, seen.board, by)) return std::nullopt;
      const Eigen::Matrix2d plane_by_board = paper.SeenByBoard(seen.board), board_by_plane = plane_by_board.inverse();
      const Eigen::Matrix2d information =
          plane_by_board.transpose().lazyProduct(seen.information.lazyProduct(plane_by_board).eval());
      Eigen::Matrix<double, LinearBend::kColumns, 2> on_board;
      for (int axis = 0; axis < 2; ++axis)
        on_board.col(axis).head<kMoves>() = BoardGeometry::MoveByParameters(seen.board, axis);
      // A pixel that shows a point which the bend moved that way has coordinates that are off the other way.
      on_board.middleRows<kBends>(kMoves) = -board_by_plane.lazyProduct(by.rightCols<kBends>()).transpose();
      on_board.row(LinearBend::kColumns - 1) = (board_by_plane * (paper.Seen(seen.board) - seen.plane)).transpose();
      const Eigen::Matrix<double, LinearBend::kColumns, 2> weighted = on_board.lazyProduct(information);
      products += on_board.lazyProduct(weighted.transpose());
    }
    return LinearBend::Of(products);
  }

  const BoardView& view_;
  std::span<const SeenCorner> seen_;
  Eigen::Vector3d taken_out_ = Eigen::Vector3d::Zero();
};

Eigen::Vector2d BentPaper::Seen(const Eigen::Vector2d& board) const {
  const Eigen::Vector3d at =
      OnPaper(rotation_, bend_, direction_, curvature_, cell_ratio_, board) + camera_from_board_.translation;
  return focal_ / at.z() * at.head<2>();
}

Eigen::Matrix2d BentPaper::SeenByBoard(const Eigen::Vector2d& board) const {
  // By differences, which are exact for parabolas.
  constexpr double kStep = 0.1;
  Eigen::Matrix2d by;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(axis);
    by.col(axis) = (Seen(board + step) - Seen(board - step)) / (2 * kStep);
  }
  return by;
}

double LeastBend::Gain(double left, std::size_t corners) const {
  return times * VarianceOfShifts(left, corners, kUnknowns);
}

bool MayBeBent(const BoardView& view, std::span<const ShiftedCorner> corners, const LeastBend& least) {
  if (view.fitted_as) return true;
  const auto starts = PosesAtCentre(view.geometry, {1, view.cell_ratio}, view.focal);
  if (!starts) return false;
  const std::optional<LinearBend> linear = FindLinearBend((*starts)[0], view.cell_ratio, corners);
  if (!linear) return false;
  return linear->gain > kRoughly * least.Gain(0, corners.size()) &&
         linear->gain > kRoughlyOfLeft * least.Gain(linear->left(), corners.size());
}

std::optional<BentPaper> FindBentPaper(const BoardView& view, std::span<const SeenCorner> corners,
                                       const LeastBend& least) {
  const auto starts = PosesAtCentre(view.geometry, {1, view.cell_ratio}, view.focal);
  if (!starts) return std::nullopt;
  BendSolver solver(view, corners);
  std::optional<BentPaper> best;
  for (const RigidTransform& start : *starts) {
    const std::optional<BentPaper> paper = solver.Bent(start);
    if (paper && (!best || paper->left() < best->left())) best = paper;
  }
  if (!best) return std::nullopt;
  // Flat paper leaves what it does in the better of its poses: most boards gain too little over the one already.
  const double flat = solver.Flat((*starts)[0]), least_gain = least.Gain(best->left(), corners.size());
  if (flat - best->left() < least_gain) return std::nullopt;
  solver.TellGain(*best, std::min(flat, solver.Flat((*starts)[1])));
  if (best->gain() < least_gain) return std::nullopt;
  if (!solver.TellUncertainty(*best)) return std::nullopt;
  return best;
}

}  // namespace chequer
