#include "evaluate/frame_score.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numbers>

namespace chequer {
namespace {

/// Index of the true board that a detection is of.
std::optional<std::size_t> BoardAt(const Eigen::Vector2d& center_px, const std::vector<TrueMarker>& boards) {
  std::optional<std::size_t> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < boards.size(); ++i) {
    const double distance = (boards[i].center_px - center_px).norm();
    const double side_px = boards[i].cell_px * std::min(boards[i].size.rows, boards[i].size.cols);
    if (distance > 0.5 * side_px || distance >= least) continue;
    least = distance;
    nearest = i;
  }
  return nearest;
}

/// Nothing where the covariance is none.
std::optional<double> OverCovariance(const Eigen::Vector3d& error, const Eigen::Matrix3d& covariance) {
  const Eigen::LLT<Eigen::Matrix3d> factor(covariance);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return error.dot(factor.solve(error)) / 3;
}

PoseError ErrorOf(const FoundMarker& found, const RigidTransform& truth) {
  const RigidTransform& pose = *found.camera_from_marker;
  const Eigen::Vector3d position = truth.translation - pose.translation;
  const Eigen::Vector3d rotation = VectorFromRotation(truth.rotation * pose.rotation.conjugate());
  PoseError error;
  error.position_mm = 1e3 * position.norm();
  error.angle_deg = rotation.norm() * 180 / std::numbers::pi;
  if (!found.covariance) return error;
  error.position_over_covariance = OverCovariance(position, found.covariance->topLeftCorner<3, 3>());
  error.rotation_over_covariance = OverCovariance(rotation, found.covariance->bottomRightCorner<3, 3>());
  return error;
}

bool IsExpected(const TrueMarker& board) { return board.inside >= kLeastInside; }
bool IsWhole(const TrueMarker& board) { return board.visible == 1; }

}  // namespace

FrameScore& FrameScore::operator+=(const FrameScore& other) {
  expected += other.expected;
  read += other.read;
  carried += other.carried;
  whole += other.whole;
  whole_read += other.whole_read;
  undecided += other.undecided;
  wrong += other.wrong;
  twice += other.twice;
  ghosts += other.ghosts;
  errors.insert(errors.end(), other.errors.begin(), other.errors.end());
  return *this;
}

FrameScore ScoreFrame(const FoundFrame& found, const FrameTruth& truth) {
  FrameScore score;
  for (const TrueMarker& board : truth.markers) {
    score.expected += IsExpected(board);
    score.whole += IsWhole(board);
  }
  std::vector<bool> read(truth.markers.size(), false);
  for (const FoundMarker& marker : found.markers) {
    if (!marker.id) {
      ++score.undecided;
      continue;
    }
    const auto at = BoardAt(marker.center_px, truth.markers);
    if (!at) {
      ++score.ghosts;
      continue;
    }
    const TrueMarker& board = truth.markers[*at];
    if (board.id != *marker.id || (!marker.variant.empty() && board.variant != marker.variant)) {
      ++score.wrong;
    } else if (read[*at]) {
      ++score.twice;
    } else {
      read[*at] = true;
      score.read += IsExpected(board);
      score.carried += IsExpected(board) && marker.carried;
      score.whole_read += IsWhole(board);
      if (!marker.camera_from_marker) continue;
      score.errors.push_back(ErrorOf(marker, board.camera_from_marker));
      score.errors.back().carried = marker.carried;
    }
  }
  return score;
}

}  // namespace chequer
