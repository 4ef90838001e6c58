#include "detect/image_state.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace chequer {
namespace {

/// What is left undone in an image is looked for within so much of its side in the next (a guess).
constexpr float kDeferredReach = 0.5f;

}  // namespace

BoardOutcome::BoardOutcome() = default;

void ImageState::AddEdgesTo(EdgeTally& tally) const {
  for (const BoardOutcome& outcome : outcomes)
    if (outcome.accepted) tally.Add(outcome.along_edges.own);
}

bool ImageState::ReadElsewhere(std::size_t board) const {
  for (std::size_t i = 0; i < outcomes.size(); ++i)
    if (i != board && Reads(outcomes[i], expected[board]) && !(IsExpected(i) && WasRead(i))) return true;
  return false;
}

bool ShowsAllCorners(const AnchoredBoard& board) {
  return board.visibility.ShowsAll() &&
         std::all_of(board.found.begin(), board.found.begin() + CornerCount(board.size), [](bool in) { return in; });
}

std::array<Eigen::Vector2d, 4> OutlineOf(MarkerSize size, const Eigen::Matrix3d& plane_from_board, const Lens& lens) {
  const double x = 0.5 * size.cols, y = 0.5 * size.rows;
  std::array<Eigen::Vector2d, 4> outline{Eigen::Vector2d(-x, -y), {x, -y}, {x, y}, {-x, y}};
  for (Eigen::Vector2d& at : outline) at = lens.ToImage((plane_from_board * at.homogeneous()).hnormalized());
  return outline;
}

double FarthestOff(const AnchoredBoard& board, const Eigen::Matrix3d& plane_from_board) {
  const Lens none;
  const auto expected = OutlineOf(board.size, board.plane_from_board, none),
             fitted = OutlineOf(board.size, plane_from_board, none);
  double farthest = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) farthest = std::max(farthest, (expected[i] - fitted[i]).norm());
  return farthest;
}

void ImageJob::Defer(const PixelBox& box, int waited, DeferredPlaces& places) const {
  places.Defer(box.Center(), kDeferredReach * box.Side(), waited);
  frame.open.push_back(box);
  ++frame.stats.deferred;
}

}  // namespace chequer
