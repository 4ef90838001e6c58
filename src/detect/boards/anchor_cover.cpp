// Placements of which a part may be occluded.
#include <algorithm>
#include <utility>

#include "detect/boards/anchor.h"

namespace chequer {
namespace {

/// Least share of cells that are clearly lighter or darker than their neighbours (a guess).
constexpr double kLeastVisible = 0.5;
/// The same share for a partly occluded board, among its other cells (a guess).
constexpr double kLeastVisibleBesides = 0.8;
/// Lines of cells along one side that may be occluded. Three would leave half of a 6 × 6 border.
constexpr int kMostCovered = 2;
/// Windows of a grid that are tried as partly occluded boards. The grid of one board has at most 40; more come from
/// textures.
constexpr int kMostWithCover = 1000;

}  // namespace

int BoardFinder::CellsBesides(const Placement& placement) {
  const int rows = placement.corners.rows + 1, cols = placement.corners.cols + 1;
  return rows * cols - placement.covered.lines * (placement.covered.side < 2 ? cols : rows);
}

int BoardFinder::ShowingBesides(const Placement& placement) const {
  const Cover& covered = placement.covered;
  const int rows = placement.corners.rows + 1, cols = placement.corners.cols + 1;
  const bool across = covered.side < 2, at_end = covered.side % 2 == 1;
  int occluded = 0;
  for (int line = 0; line < covered.lines; ++line) {
    const int at = at_end ? (across ? rows : cols) - 1 - line : line;
    for (int i = 0; i < (across ? cols : rows); ++i)
      occluded += grid_->visible[static_cast<std::size_t>(across ? at * cols + i : i * cols + at)];
  }
  return grid_->showing - occluded;
}

bool BoardFinder::ShowsEnough(const Placement& placement) {
  const int besides = CellsBesides(placement);
  // What is left of a covered board has to be beyond doubt.
  const double least = (placement.covered.lines ? kLeastVisibleBesides : kLeastVisible) * besides;
  const int showing = ShowingBesides(placement);
  return showing >= least || Refuse(placement, Refusal::kCellsDoNotShow, showing, least);
}

bool BoardFinder::JudgeCovered(Placement& placement) {
  if (++grid_->with_cover > kMostWithCover) return false;
  // The cover lies where it explains most of what does not show: at another side, the border that is left may match
  // too.
  std::array<std::pair<int, int>, 4> sides;
  for (placement.covered.lines = 1; placement.covered.lines <= kMostCovered; ++placement.covered.lines) {
    for (int side = 0; side < 4; ++side) {
      placement.covered.side = side;
      sides[static_cast<std::size_t>(side)] = {CellsBesides(placement) - ShowingBesides(placement), side};
    }
    std::sort(sides.begin(), sides.end());
    for (const auto& [not_showing, side] : sides) {
      placement.covered.side = side;
      if (ShowsEnough(placement) && JudgeBorder(placement)) return true;
    }
  }
  return false;
}

}  // namespace chequer
