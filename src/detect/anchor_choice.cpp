// Which of the placements are boards.
#include <algorithm>
#include <cmath>

#include "detect/anchor.h"

namespace chequer {
namespace {

/// Share of a line of the lattice that holds corners if it lies inside a checkerboard for sure.
constexpr double kLeastOfLine = 1;
/// A side of a window goes on if at least this share of the cells beyond it are like those inside it, to so much of the
/// contrast; with so many sides that do,
/// the window is a part of a larger board.
constexpr double kLeastAlike = 0.8;
constexpr float kAlike = 0.35f;
constexpr int kMostSides = 2;
/// How much a placement must beat those it overlaps with.
constexpr double kLeastLead = 3;

}  // namespace

void BoardFinder::TakeBest(const LightReader& reader, const Lens& lens, std::vector<AnchoredBoard>& boards) {
  std::sort(placements_.begin(), placements_.end(),
            [](const Placement& a, const Placement& b) { return a.score > b.score; });
  taken_.clear();
  for (std::size_t i = 0; i < placements_.size(); ++i) {
    const auto overlaps_taken = [&](std::size_t k) {
      return std::any_of(taken_.begin(), taken_.end(),
                         [&](std::size_t t) { return SharesCells(placements_[t].corners, placements_[k].corners); });
    };
    if (overlaps_taken(i)) continue;
    bool rivalled = false;
    for (std::size_t k = i + 1; k < placements_.size() && !rivalled; ++k)
      rivalled = placements_[k].score > placements_[i].score - kLeastLead &&
                 SharesCells(placements_[i].corners, placements_[k].corners) && !overlaps_taken(k);
    if (rivalled) {
      Refuse(placements_[i], Refusal::kRivalled, 0, 0);
      continue;
    }
    taken_.push_back(i);
  }
  for (const std::size_t i : taken_) {
    if (SidesThatGoOn(placements_[i], reader) >= kMostSides) {
      Refuse(placements_[i], Refusal::kGoesOn, 0, 0);
      continue;
    }
    AnchoredBoard board = TakeSpare();
    const bool built = Build(placements_[i], reader, lens, board);
    (built ? boards : spare_).push_back(std::move(board));
  }
}

bool BoardFinder::HasCornersOnItsSides(const Lattice::Window& window) const {
  const auto on_line = [&](int x, int y, int along_x, int along_y, int length) {
    int count = 0;
    for (int i = 0; i < length; ++i) count += lattice_.At(x + i * along_x, y + i * along_y) != nullptr;
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
    return std::any_of(taken_.begin(), taken_.end(), [&](std::size_t k) {
      const Lattice::Window& other = placements_[k].corners;
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
