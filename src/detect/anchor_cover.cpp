// Placements of which a part may be hidden.
#include "detect/anchor.h"

namespace chequer {
namespace {

/// Least share of cells that must be seen as lighter or darker than their neighbours.
constexpr double kLeastVisible = 0.5;
/// The same of a board that something lies over, of the other cells.
constexpr double kLeastVisibleBesides = 0.8;
/// Lines of cells along one side that something may lie over.
constexpr int kMostCovered = 2;

}  // namespace

int BoardFinder::ShowingBesides(const Placement& placement) const {
  const Cover& covered = placement.covered;
  const int rows = placement.corners.rows + 1, cols = placement.corners.cols + 1;
  const bool across = covered.side < 2, at_end = covered.side % 2 == 1;
  int hidden = 0;
  for (int line = 0; line < covered.lines; ++line) {
    const int at = at_end ? (across ? rows : cols) - 1 - line : line;
    for (int i = 0; i < (across ? cols : rows); ++i)
      hidden += visible_[static_cast<std::size_t>(across ? at * cols + i : i * cols + at)];
  }
  return showing_ - hidden;
}

bool BoardFinder::ShowsEnough(const Placement& placement) {
  const int rows = placement.corners.rows + 1, cols = placement.corners.cols + 1;
  const int lines = placement.covered.lines, hidden = lines * (placement.covered.side < 2 ? cols : rows);
  // What is left of a covered board has to be beyond doubt.
  const double least = (lines ? kLeastVisibleBesides : kLeastVisible) * (rows * cols - hidden);
  const int showing = ShowingBesides(placement);
  return showing >= least || Refuse(placement, Refusal::kCellsDoNotShow, showing, least);
}

bool BoardFinder::JudgeCovered(Placement& placement) {
  for (placement.covered.lines = 1; placement.covered.lines <= kMostCovered; ++placement.covered.lines)
    for (placement.covered.side = 0; placement.covered.side < 4; ++placement.covered.side)
      if (ShowsEnough(placement) && JudgeBorder(placement)) return true;
  return false;
}

}  // namespace chequer
