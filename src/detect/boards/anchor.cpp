#include "detect/boards/anchor.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/median.h"

namespace chequer {
namespace {

/// Least share of a board's corners that were found (a guess: ten of 25).
constexpr double kLeastCorners = 0.38;
/// Least share of the corners of the window that has the most (a guess).
constexpr double kLeastOfMost = 0.8;
/// Two lines of cells may be occluded where less of the border shows than this share. Of a 6 × 6 border, one line
/// leaves 0.7 and two leave 0.6.
constexpr double kAllButTwoLines = 0.66;
/// In narrower cells, half of what a window measures comes from their neighbours, by blur and interpolation (a guess).
constexpr double kSmallCellPx = 4;
/// The most units that one window takes, its share of the work before it included (a guess).
constexpr std::uint64_t kUnitsOfWindow = 30;

}  // namespace

BoardFinder::Sought::Sought(std::vector<BorderPattern> given_patterns, ColorSpace given_space)
    : patterns(std::move(given_patterns)), space(given_space) {
  for (const BorderPattern& pattern : patterns)
    most_corners = std::max({most_corners, pattern.size.rows - 1, pattern.size.cols - 1});
}

BoardFinder::BoardFinder(std::vector<BorderPattern> patterns, ColorSpace space) : sought_(std::move(patterns), space) {}

float BoardFinder::ContrastOf(const std::vector<Corner>& corners) const {
  float sum = 0, count = 0;
  for (std::size_t i = 0; i < corners.size(); ++i)
    if ((*claimed_)[i]) sum += corners[i].contrast, count += 1;
  return sum / std::max(count, 1.0f);
}

bool BoardFinder::FitWindow(const Lattice::Window& window, std::vector<PointPair>* pairs) {
  const auto homography = grid_->lattice.Fit(window, pairs);
  if (!homography) return false;
  grid_->image_from_lattice = *homography;
  return true;
}

void BoardFinder::TryWindow(int pattern, const Lattice::Window& window, bool turned, const LightReader& reader) {
  const MarkerSize size = sought_.patterns[static_cast<std::size_t>(pattern)].size;
  if (grid_->mixed) {
    // Only where a checkerboard shows: clutter is not worth it.
    MarkVisible(window, reader);
    if (ShowsEnough({.pattern = pattern, .corners = window, .covered = {}})) UnmixCells(reader);
  }
  bool marked = false;
  // A square board's footprint is the same for all turns.
  const int step = size.rows == size.cols ? 1 : 2;
  for (int turn = turned ? 1 : 0; turn < 4; turn += step) {
    Placement placement{.pattern = pattern, .corners = window, .turn = turn, .covered = {}};
    // The lattice's cell (i, j) is light where i + j is even; the board's first cell is dark.
    const Cell first = InFootprint(size, 0, 0, placement.turn);
    if ((window.x - 1 + first.col + window.y - 1 + first.row) % 2 == 0) continue;
    grid_->work.Add(WorkStep::kWindow);
    const bool may_be = MayBeBorder(sought_.patterns[static_cast<std::size_t>(pattern)], window, turn, reader);
    if (!may_be && !grid_->attempt) continue;
    if (!marked) MarkVisible(window, reader);
    marked = true;
    if (!may_be) {
      Refuse(placement, Refusal::kNoYellow, 0, 0);
      continue;
    }
    if (!(ShowsEnough(placement) && (JudgeBorder(placement) || JudgeUnmixed(placement, reader))) &&
        !JudgeCovered(placement))
      continue;
    // The border's period is four cells: turned by half a turn and two cells off, a board with two lines occluded looks
    // the same, but one of its sides lies inside the board in truth.
    if (placement.border_seen < kAllButTwoLines * BorderLength(size) && HasCornersOnItsSides(window)) {
      Refuse(placement, Refusal::kGoesOn, 0, 0);
      continue;
    }
    grid_->placements.push_back(placement);
  }
}

void BoardFinder::TryWindows(int pattern, bool turned, const LightReader& reader) {
  const MarkerSize size = sought_.patterns[static_cast<std::size_t>(pattern)].size;
  const Lattice::Window& all = grid_->lattice.window();
  grid_->windows.clear();
  Lattice::Window window{0, 0, (turned ? size.rows : size.cols) - 1, (turned ? size.cols : size.rows) - 1};
  const double least = std::max<double>(GridLinker::kFewest, kLeastCorners * window.cols * window.rows);
  int most = 0;
  for (window.y = all.y; window.y + window.rows <= all.y + all.rows; ++window.y)
    for (window.x = all.x; window.x + window.cols <= all.x + all.cols; ++window.x) {
      const int count = grid_->lattice.Count(window);
      most = std::max(most, count);
      if (count >= least) grid_->windows.emplace_back(count, window);
    }
  if (grid_->windows.empty())
    Refuse({.pattern = pattern, .corners = {}, .covered = {}}, Refusal::kFewCorners, most, std::ceil(least));
  // A board that is seen in part still has nearly all the corners that there are.
  const bool one_board = all.cols < 2 * window.cols && all.rows < 2 * window.rows;
  // What is beyond doubt spares the others around it, which have fewer corners for the most part.
  std::sort(grid_->windows.begin(), grid_->windows.end(), [](const auto& a, const auto& b) {
    return std::tuple(-a.first, a.second.y, a.second.x) < std::tuple(-b.first, b.second.y, b.second.x);
  });
  if (grid_->limit.waited > 0 && !one_board && !grid_->windows.empty()) {
    const std::uint64_t tried =
        static_cast<std::uint64_t>(grid_->limit.waited) * (grid_->limit.units / kUnitsOfWindow + 1);
    std::rotate(grid_->windows.begin(),
                grid_->windows.begin() + static_cast<std::ptrdiff_t>(tried % grid_->windows.size()),
                grid_->windows.end());
  }
  grid_->spared.assign(static_cast<std::size_t>(all.cols * all.rows), 0);
  grid_->work.Add(WorkStep::kLatticePoint, grid_->spared.size());
  for (const auto& counted : grid_->windows) {
    if (one_board && counted.first <= kLeastOfMost * most) break;
    const Lattice::Window& at = counted.second;
    if (grid_->spared[static_cast<std::size_t>((at.y - all.y) * all.cols + at.x - all.x)]) continue;
    if (grid_->left_undone = work().units() > grid_->limit.units; grid_->left_undone) break;
    const std::size_t before = grid_->placements.size();
    TryWindow(pattern, at, turned, reader);
    const auto first_new = grid_->placements.begin() + static_cast<std::ptrdiff_t>(before);
    if (std::any_of(first_new, grid_->placements.end(), [&](const Placement& each) { return IsBeyondDoubt(each); }))
      SpareAround(at);
  }
}

void BoardFinder::SpareAround(const Lattice::Window& window) {
  const Lattice::Window& all = grid_->lattice.window();
  const int last_x = std::min(window.x + window.cols, all.x + all.cols - 1),
            last_y = std::min(window.y + window.rows, all.y + all.rows - 1);
  for (int y = std::max(window.y - window.rows, all.y); y <= last_y; ++y)
    for (int x = std::max(window.x - window.cols, all.x); x <= last_x; ++x)
      grid_->spared[static_cast<std::size_t>((y - all.y) * all.cols + x - all.x)] = 1;
}

bool BoardFinder::IsBeyondDoubt(const Placement& placement) const {
  const Lattice::Window& window = placement.corners;
  const int border = BorderLength(sought_.patterns[static_cast<std::size_t>(placement.pattern)].size);
  return grid_->lattice.Count(window) == window.cols * window.rows && placement.border_seen == border &&
         placement.border_matches == border;
}

bool BoardFinder::Build(const Placement& placement, const LightReader& reader, const Lens& lens, AnchoredBoard& board) {
  const Lattice::Window& window = placement.corners;
  board.size = sought_.patterns[static_cast<std::size_t>(placement.pattern)].size;
  if (grid_->shared && grid_->lattice.Count(window) == grid_->lattice.Count(grid_->lattice.window())) {
    // The same corners, which were fitted already.
    grid_->pairs = grid_->shared_pairs;
  } else if (!FitWindow(window, &grid_->pairs)) {
    return Refuse(placement, Refusal::kNotPlane, 0, 0);
  }
  ResampleByHomography(window, reader);
  Placement judged = placement;
  // Of the same samples, it would be judged as before.
  if (!(grid_->shared && window == grid_->marked)) {
    MarkVisible(window, reader);
    if (!JudgeBorder(judged)) return false;
  }
  grid_->work.Add(WorkStep::kBoard);
  DescribeCells(judged, board);
  for (const PointPair& pair : grid_->pairs)
    board.box.Add(static_cast<float>(pair.to.x()), static_cast<float>(pair.to.y()));
  board.box.Widen(1.0f / static_cast<float>(std::min(window.cols, window.rows)));
  if (!PlaceOnPlane(placement, lens, board)) return Refuse(placement, Refusal::kNotPlane, 0, 0);
  ClaimCorners(placement, board);
  return true;
}

Eigen::Vector2d BoardFinder::OnBoard(const Placement& placement, const Eigen::Vector2d& lattice) {
  const Lattice::Window& window = placement.corners;
  const Eigen::Vector2d center(window.x + 0.5 * (window.cols - 1), window.y + 0.5 * (window.rows - 1));
  constexpr std::array<int, 4> kCos{1, 0, -1, 0}, kSin{0, 1, 0, -1};
  const int cos = kCos[static_cast<std::size_t>(placement.turn)], sin = kSin[static_cast<std::size_t>(placement.turn)];
  return (Eigen::Matrix2d() << cos, sin, -sin, cos).finished() * (lattice - center);
}

bool BoardFinder::PlaceOnPlane(const Placement& placement, const Lens& lens, AnchoredBoard& board) {
  const Lattice::Window& window = placement.corners;
  // Where all corners agree, what the lens does to a few points of their homography tells as much as to all of them.
  if (static_cast<int>(grid_->pairs.size()) == window.cols * window.rows) {
    grid_->pairs.clear();
    for (const double y : {0.0, 0.5, 1.0})
      for (const double x : {0.0, 0.5, 1.0}) {
        const Eigen::Vector2d at(window.x + x * (window.cols - 1), window.y + y * (window.rows - 1));
        grid_->pairs.push_back({at, (grid_->image_from_lattice * at.homogeneous()).hnormalized()});
      }
  }
  for (PointPair& pair : grid_->pairs) {
    const auto plane = lens.ToPlane(pair.to);
    if (!plane) return false;
    pair = {OnBoard(placement, pair.from), *plane};
  }
  const auto homography = FitHomography(grid_->pairs);
  if (homography) board.plane_from_board = *homography;
  return homography.has_value();
}

void BoardFinder::ClaimCorners(const Placement& placement, AnchoredBoard& board) {
  const Lattice::Window& window = placement.corners;
  grid_->sorted.clear();
  for (int y = window.y; y < window.y + window.rows; ++y)
    for (int x = window.x; x < window.x + window.cols; ++x)
      if (const Lattice::Point* point = grid_->lattice.At(x, y)) {
        grid_->sorted.push_back(point->scale);
        (*claimed_)[static_cast<std::size_t>(point->corner)] = 1;
        const Eigen::Vector2d at = OnBoard(placement, Eigen::Vector2d(x, y));
        const int row = static_cast<int>(std::lround(at.y() + 0.5 * (board.size.rows - 2))),
                  col = static_cast<int>(std::lround(at.x() + 0.5 * (board.size.cols - 2)));
        board.found[static_cast<std::size_t>(row * (board.size.cols - 1) + col)] = true;
      }
  board.scale = MedianInPlace(grid_->sorted);
}

bool BoardFinder::Find(const Grid& grid, std::span<const LatticeCorner> members, const std::vector<Corner>& corners,
                       const CornerSearch* search, const LightReader& reader, const Lens& lens,
                       std::vector<AnchoredBoard>& boards, TraceCandidate* attempt, const GridLimit& limit) {
  grid_.Start().attempt = attempt;
  grid_->limit = limit;
  if (!grid_->lattice.Read(grid, members, corners, search, *claimed_, reader.width(), reader.height(),
                           sought_.most_corners))
    return Refuse({.corners = {}, .covered = {}}, Refusal::kNotOneLattice, 0, 0);
  const Lattice::Window& all = grid_->lattice.window();
  grid_->cell_window = {all.x - 2, all.y - 2, all.cols + 3, all.rows + 3};
  grid_->cells.assign(static_cast<std::size_t>(grid_->cell_window.cols * grid_->cell_window.rows), CellSample{});
  // A grid that fits into a board, more or less, lies on one plane.
  const int cols = grid.max_x - grid.min_x + 1, rows = grid.max_y - grid.min_y + 1;
  grid_->shared =
      cols <= sought_.most_corners + 2 && rows <= sought_.most_corners + 2 && FitWindow(all, &grid_->shared_pairs);
  if (grid_->shared) {
    const double side = PlaceByHomography(all.x + all.cols / 2 - 1, all.y + all.rows / 2 - 1).side;
    grid_->mixed = !CellUnmixer::WindowsAreClear(reader, side, CellMesh{}.blur_px);
    grid_->small = !grid_->mixed && side < kSmallCellPx;
  }
  for (int pattern = 0; pattern < static_cast<int>(sought_.patterns.size()); ++pattern) {
    const MarkerSize size = sought_.patterns[static_cast<std::size_t>(pattern)].size;
    for (const bool turned : {false, true}) {
      if (turned && size.rows == size.cols) continue;
      TryWindows(pattern, turned, reader);
    }
  }
  const std::size_t before = boards.size();
  TakeBest(reader, lens, boards);
  return boards.size() > before;
}

}  // namespace chequer
