#include "detect/camera_motion.h"

#include <Eigen/LU>
#include <optional>
#include <vector>

#include "detect/memory/common_shift.h"

namespace chequer {
namespace {

/// Motion blur in addition to a board's own motion. Where there is less, a fit that does not know it is as fast (a
/// guess).
constexpr double kMotionOfCameraPx = 2;

Eigen::Vector2d PlaceOf(const Eigen::Matrix3d& plane_from_board) { return plane_from_board.topRightCorner<2, 1>(); }

/// A board that lies so much farther on, plane units.
Eigen::Matrix3d MovedBy(const Eigen::Vector2d& off, Eigen::Matrix3d plane_from_board) {
  plane_from_board.topRows<2>() += off * plane_from_board.row(2);
  return plane_from_board;
}

/// Derivative of the image by the plane.
Eigen::Matrix2d PixelByPlane(const Lens& lens, const Eigen::Vector2d& place) {
  Eigen::Matrix2d pixel_by_plane;
  lens.ToImage(place, &pixel_by_plane);
  return pixel_by_plane;
}

/// How a board was expected to move by itself. The rest is left zero.
MovedBoard OwnMotionOf(const ImageState& frame, std::size_t board) {
  const RememberedBoard& last = frame.expected[board];
  const Eigen::Matrix3d now = last.Ahead(frame.stream.ahead_s);
  return {.place = PlaceOf(frame.boards[board].plane_from_board),
          .own_way = PlaceOf(now - last.plane_from_board),
          .own_turn = TurnBetween(last.plane_from_board, now)};
}

/// The same of one that was read there, with how it was fitted; nothing where its own motion is not known.
std::optional<MovedBoard> MotionOf(const ImageJob& job, std::size_t board) {
  const ImageState& frame = job.frame;
  if (!frame.IsExpected(board) || !frame.WasRead(board) || !frame.expected[board].is_followed()) return std::nullopt;
  const BoardOutcome& outcome = frame.outcomes[board];
  MovedBoard moved = OwnMotionOf(frame, board);
  moved.way = PixelByPlane(job.lens, moved.place).inverse() * outcome.motion.way_px;
  moved.turn = outcome.motion.turn;
  moved.off = PlaceOf(outcome.plane_from_board) - moved.place;
  return moved;
}

/// Whether it moved by more than its own motion.
bool ShowsMotionOfCamera(const MovedBoard& board) {
  // No board moves farther by itself while the shutter is open than from one frame to the next.
  return board.way.norm() > board.own_way.norm() + kMotionOfCameraPx;
}

}  // namespace

bool ShowsMotion(const ImageState& frame) {
  return !frame.expected.empty() && frame.traits && !frame.traits->motion_px.isZero();
}

void LearnMotion(const ImageJob& job, std::span<const FitTask> fitted) {
  StreamState& stream = job.frame.stream;
  if (!ShowsMotion(job.frame) && !stream.IsKnocked()) return;
  for (const FitTask& task : fitted) {
    const std::optional<MovedBoard> moved = MotionOf(job, task.board);
    if (moved && !moved->way.isZero()) stream.moved.push_back(*moved);
  }
  if (stream.moved.size() >= kFewestThatMoved || (!stream.moved.empty() && ShowsMotionOfCamera(stream.moved.front())))
    stream.motion = CommonMotion::Find(stream.moved, job.lens);
}

void FollowCamera(const ImageJob& job, std::size_t board, PhotometricFit::Start& start) {
  const ImageState& frame = job.frame;
  if (!frame.stream.motion || !frame.IsExpected(board) || !frame.expected[board].is_followed()) return;
  const MovedBoard moved = frame.stream.motion->Of(OwnMotionOf(frame, board));
  start.motion = {PixelByPlane(job.lens, moved.place) * moved.way, moved.turn};
  start.board.geometry = BoardGeometry(MovedBy(moved.off, frame.boards[board].plane_from_board));
}

LastPlaces::LastPlaces(const ImageJob& job) : lens_(job.lens), shift_px_(job.frame.stream.shift_px), turn_(job.lens) {
  ImageState& frame = job.frame;
  if (!frame.stream.IsKnocked()) return;
  std::vector<MovedBoard>& moved = frame.stream.moved;
  moved.clear();
  for (std::size_t i = 0; i < frame.expected.size(); ++i)
    if (const std::optional<MovedBoard> board = MotionOf(job, i)) moved.push_back(*board);
  if (moved.size() >= kFewestThatMoved) turn_ = FindTurn(moved, lens_);
  // What moved all boards by as much may have been either that or an own motion that was remembered wrongly, which
  // would have to be corrected in every frame from then on: what leaves the boards slower is likelier.
  double own = 0, with_camera = 0;
  for (std::size_t i = 0; i < frame.expected.size(); ++i) {
    if (!frame.outcomes[i].accepted) continue;
    const Eigen::Matrix3d &last = frame.expected[i].plane_from_board, &now = frame.outcomes[i].plane_from_board;
    own += PlaceOf(now - last).norm();
    with_camera += PlaceOf(now - Of(last)).norm();
  }
  if (with_camera < own) return;
  shift_px_.setZero();
  turn_.by.setZero();
}

Eigen::Matrix3d LastPlaces::Of(const Eigen::Matrix3d& plane_from_board) const {
  if (same()) return plane_from_board;
  const Eigen::Matrix3d shifted = Shifted(plane_from_board, shift_px_, lens_);
  return MovedBy(turn_.At(PlaceOf(shifted)), shifted);
}

}  // namespace chequer
