// Which of the placements are boards.
#include <algorithm>
#include <cmath>

#include "detect/boards/placement.h"

namespace chequer {
namespace {

/// Share of a line of the lattice that holds corners if it lies inside a checkerboard for sure.
constexpr double kLeastOfLine = 1;
/// The board goes on beyond a side if at least kLeastAlike of the cells there equal those inside, to kAlike of the
/// contrast. A window that goes on beyond kMostSides sides is a part of a larger board (guesses).
constexpr double kLeastAlike = 0.8;
constexpr float kAlike = 0.35f;
constexpr int kMostSides = 2;
/// How much the score of a placement must exceed those of the placements it overlaps (a guess).
constexpr double kClearLead = 3;

}  // namespace

void PlacementChoice::Choose(std::vector<Placement>& placements, WorkMeter& work) {
  std::sort(placements.begin(), placements.end(),
            [](const Placement& a, const Placement& b) { return a.score > b.score; });
  const auto overlaps_taken = [&](const Placement& placement) {
    return std::any_of(taken.begin(), taken.end(), [&](std::size_t t) { return placements[t].SharesCells(placement); });
  };
  for (std::size_t i = 0; i < placements.size(); ++i) {
    work.Add(WorkStep::kComparison, taken.size());
    if (overlaps_taken(placements[i])) continue;
    bool has_rival = false;
    const double least = placements[i].score - kClearLead;
    for (std::size_t k = i + 1; k < placements.size() && placements[k].score > least && !has_rival; ++k) {
      work.Add(WorkStep::kComparison);
      has_rival = placements[i].SharesCells(placements[k]) && !overlaps_taken(placements[k]);
    }
    (has_rival ? rivalled : taken).push_back(i);
  }
}

bool HasCornersOnItsSides(const Lattice& lattice, const Lattice::Window& window) {
  const auto on_line = [&](int x, int y, int along_x, int along_y, int length) {
    int count = 0;
    for (int i = 0; i < length; ++i) count += lattice.At(x + i * along_x, y + i * along_y) != nullptr;
    return count >= kLeastOfLine * length;
  };
  return on_line(window.x, window.y - 1, 1, 0, window.cols) ||
         on_line(window.x, window.y + window.rows, 1, 0, window.cols) ||
         on_line(window.x - 1, window.y, 0, 1, window.rows) ||
         on_line(window.x + window.cols, window.y, 0, 1, window.rows);
}

bool GoesOn(const Placement& placement, const std::vector<Placement>& placements, const PlacementChoice& choice,
            LatticeCells& cells) {
  const Lattice::Window& window = placement.corners;
  const int left = window.x - 1, top = window.y - 1, right = left + window.cols, bottom = top + window.rows;  // cells
  const auto value = [&](int x, int y) {
    const CellSample& sample = cells.At(x, y);
    return sample.inside ? std::sqrt(sample.light[0] + sample.light[1]) : -1;
  };
  const auto of_another_board = [&](int x, int y) {
    return std::any_of(choice.taken.begin(), choice.taken.end(), [&](std::size_t k) {
      const Lattice::Window& other = placements[k].corners;
      return x >= other.x - 1 && y >= other.y - 1 && x < other.x + other.cols && y < other.y + other.rows;
    });
  };
  // A side goes on if the cells beyond it are as much lighter and darker as those inside.
  const auto side_goes_on = [&](int x, int y, int along_x, int along_y, int out_x, int out_y, int length) {
    const auto is_alike = [&] {
      if (of_another_board(x + out_x, y + out_y)) return false;
      const float inner = value(x, y), outer = value(x + out_x, y + out_y), within = value(x - out_x, y - out_y);
      return inner >= 0 && outer >= 0 && within >= 0 && std::abs(outer - within) < kAlike * std::abs(within - inner);
    };
    // Most sides are a board's own: the first few cells tell, and no more are sampled.
    int different = 0;
    for (int i = 0; i < length; ++i, x += along_x, y += along_y) {
      different += !is_alike();
      if (length - different < kLeastAlike * length) return false;
    }
    return true;
  };
  const int cols = placement.cols(), rows = placement.rows();
  return side_goes_on(left, top, 1, 0, 0, -1, cols) + side_goes_on(left, bottom, 1, 0, 0, 1, cols) +
             side_goes_on(left, top, 0, 1, -1, 0, rows) + side_goes_on(right, top, 0, 1, 1, 0, rows) >=
         kMostSides;
}

}  // namespace chequer
