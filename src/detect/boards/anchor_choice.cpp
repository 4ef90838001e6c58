// Which of the placements are boards.
#include <algorithm>
#include <cmath>

#include "detect/boards/anchor.h"

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
constexpr double kLeastLead = 3;

}  // namespace

void BoardFinder::TakeBest(const LightReader& reader, const Lens& lens, std::vector<AnchoredBoard>& boards) {
  std::sort(grid_->placements.begin(), grid_->placements.end(),
            [](const Placement& a, const Placement& b) { return a.score > b.score; });
  for (std::size_t i = 0; i < grid_->placements.size(); ++i) {
    const auto overlaps_taken = [&](std::size_t k) {
      return std::any_of(grid_->taken.begin(), grid_->taken.end(), [&](std::size_t t) {
        return SharesCells(grid_->placements[t].corners, grid_->placements[k].corners);
      });
    };
    grid_->work.Add(WorkStep::kComparison, grid_->taken.size());
    if (overlaps_taken(i)) continue;
    bool rivalled = false;
    const double least = grid_->placements[i].score - kLeastLead;
    for (std::size_t k = i + 1; k < grid_->placements.size() && grid_->placements[k].score > least && !rivalled; ++k) {
      grid_->work.Add(WorkStep::kComparison);
      rivalled = SharesCells(grid_->placements[i].corners, grid_->placements[k].corners) && !overlaps_taken(k);
    }
    if (rivalled) {
      Refuse(grid_->placements[i], Refusal::kRivalled, 0, 0);
      continue;
    }
    grid_->taken.push_back(i);
  }
  for (const std::size_t i : grid_->taken) {
    if (SidesThatGoOn(grid_->placements[i], reader) >= kMostSides) {
      Refuse(grid_->placements[i], Refusal::kGoesOn, 0, 0);
      continue;
    }
    if (!Build(grid_->placements[i], reader, lens, boards.emplace_back())) boards.pop_back();
  }
}

bool BoardFinder::HasCornersOnItsSides(const Lattice::Window& window) const {
  const auto on_line = [&](int x, int y, int along_x, int along_y, int length) {
    int count = 0;
    for (int i = 0; i < length; ++i) count += grid_->lattice.At(x + i * along_x, y + i * along_y) != nullptr;
    return count >= kLeastOfLine * length;
  };
  return on_line(window.x, window.y - 1, 1, 0, window.cols) ||
         on_line(window.x, window.y + window.rows, 1, 0, window.cols) ||
         on_line(window.x - 1, window.y, 0, 1, window.rows) ||
         on_line(window.x + window.cols, window.y, 0, 1, window.rows);
}

int BoardFinder::SidesThatGoOn(const Placement& placement, const LightReader& reader) {
  const Lattice::Window& window = placement.corners;
  const int left = window.x - 1, top = window.y - 1, right = left + window.cols, bottom = top + window.rows;  // cells
  const auto value = [&](int x, int y) {
    const CellSample& sample = CellAt(x, y, reader);
    return sample.inside ? std::sqrt(sample.light[0] + sample.light[1]) : -1;
  };
  const auto of_another_board = [&](int x, int y) {
    return std::any_of(grid_->taken.begin(), grid_->taken.end(), [&](std::size_t k) {
      const Lattice::Window& other = grid_->placements[k].corners;
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
  const int cols = window.cols + 1, rows = window.rows + 1;
  return side_goes_on(left, top, 1, 0, 0, -1, cols) + side_goes_on(left, bottom, 1, 0, 0, 1, cols) +
         side_goes_on(left, top, 0, 1, -1, 0, rows) + side_goes_on(right, top, 0, 1, 1, 0, rows);
}

}  // namespace chequer
