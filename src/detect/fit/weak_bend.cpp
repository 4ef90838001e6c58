#include "detect/fit/weak_bend.h"

#include <cmath>

#include "core/small_cholesky.h"
#include "detect/common/widened.h"

namespace chequer {
namespace {

/// A bend is as likely as none where it explains so many variances more: flat paper is as much likelier before the
/// image is seen, and three unknowns explain some of any noise (measured: with 16, squared errors of bent boards are
/// .02 larger; with 10, poses of flat boards with and without memory differ by up to a tenth more, as shares do.
/// Standard deviations of flat boards grow by less than .2 % with either).
constexpr double kEvenGain = 14;
/// Bends that are less likely are none, which saves most flat boards the mean (a choice; squared errors of bent boards
/// grow by .01 to .02 in the mean). From there on they count more and more, so that poses do not jump.
constexpr double kLeastShare = 0.1;

/// How likely a bend is that explains so many variances.
double ShareOf(double gain) { return 1 / (1 + std::exp((kEvenGain - gain) / 2)); }

/// What the pose nearest to a homography leaves of it, by its information: one step of least squares.
double LeftByPose(const BoardGeometry::Parameters& off, const HomographyByPose& by_pose,
                  const BoardGeometry::Information& information) {
  const BoardGeometry::Parameters weighted = information.lazyProduct(off);
  const HomographyByPose weighted_by_pose = information.lazyProduct(by_pose);
  const Eigen::Matrix<double, 6, 1> gradient = by_pose.transpose().lazyProduct(weighted);
  const Matrix6d normal = by_pose.transpose().lazyProduct(weighted_by_pose);
  return off.dot(weighted) - gradient.dot(SmallCholesky<6>(normal).Solve(gradient));
}

/// What the board is if its paper is bent.
struct OnBentPaper {
  BoardGeometry::Parameters moved = BoardGeometry::Parameters::Zero();  ///< the homography's, from those on flat paper
  BoardGeometry::Information information = BoardGeometry::Information::Zero();
};

/// The mean of a board on flat paper and on bent paper, which is that likely.
BoardMeasurement MeanOf(const BoardMeasurement& flat, const OnBentPaper& bent, double share) {
  BoardMeasurement mean = flat;
  BoardGeometry between(flat.plane_from_board);
  between.Add(share * bent.moved);
  mean.plane_from_board = between.plane_from_board();
  mean.information = InverseOf<LinearBend::kMoves>((1 - share) * InverseOf<LinearBend::kMoves>(flat.information) +
                                                   share * InverseOf<LinearBend::kMoves>(bent.information) +
                                                   share * (1 - share) * bent.moved * bent.moved.transpose());
  return mean;
}

}  // namespace

std::optional<BoardMeasurement> AllowForBend(const BendEvidence& evidence, const BoardMeasurement& flat,
                                             const PlanePose& pose) {
  const std::vector<ShiftedCorner>& corners = evidence.corners;
  if (corners.empty()) return std::nullopt;
  RigidTransform camera_from_board = pose.camera_from_board;
  camera_from_board.translation /= flat.cell_m;
  const std::optional<LinearBend> bend = FindLinearBend(camera_from_board, flat.cell_height_m / flat.cell_m, corners);
  if (!bend) return std::nullopt;
  // What flat paper leaves unexplained is noise only if the paper is flat.
  const double variance = VarianceOfShifts(bend->left(), corners.size(), LinearBend::kMoves + LinearBend::kBends);
  const double gain = bend->gain / variance, surer = evidence.flat_variance / variance;
  if (ShareOf(gain + surer * pose.chi_square) < kLeastShare) return std::nullopt;
  const BoardGeometry geometry(flat.plane_from_board);
  const BoardGeometry::Information by_moves = geometry.ParametersByMoves();
  const OnBentPaper bent{.moved = by_moves * (bend->moves_by_bend * bend->bend),
                         .information = Widened<LinearBend::kBends>(
                             flat.information, std::sqrt(evidence.flat_variance) * by_moves * bend->UncertainMoves())};
  // A bend looks like a tilt: what tells of it is as much that no pose makes the homography of the flat board.
  HomographyByPose by_pose;
  const BoardGeometry::Parameters of_pose =
      HomographyOfPose(pose.camera_from_board, {flat.cell_m, flat.cell_height_m}, flat.focal_px, &by_pose);
  const double left = LeftByPose(geometry.parameters() + bent.moved - of_pose, by_pose, bent.information);
  const double share = ShareOf(gain + surer * (pose.chi_square - left));
  if (!(share > kLeastShare)) return std::nullopt;
  return MeanOf(flat, bent, (share - kLeastShare) / (1 - kLeastShare));
}

}  // namespace chequer
