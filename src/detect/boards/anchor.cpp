#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/median.h"
#include "detect/boards/boards.h"

namespace chequer {
namespace {

/// Least share of a board's corners that were found (a guess: ten of 25).
constexpr double kLeastCorners = 0.38;
/// Least share of the corners of the window that has the most (a guess).
constexpr double kLeastOfMost = 0.8;
/// Two lines of cells may be occluded where less of the border shows than this share. Of a 6 × 6 border, one line
/// leaves 0.7 and two leave 0.6.
constexpr double kAllButTwoLines = 0.66;
/// Lines of cells along one side that may be occluded. Three would leave half of a 6 × 6 border.
constexpr int kMostCovered = 2;
/// Windows of a grid that are tried as partly occluded boards. The grid of one board has at most 40; more come from
/// textures.
constexpr int kMostWithCover = 1000;
/// The most units that one window takes, its share of the work before it included (a guess).
constexpr std::uint64_t kUnitsOfWindow = 30;

int MostCorners(const std::vector<BorderPattern>& patterns) {
  int most = 0;
  for (const BorderPattern& pattern : patterns) most = std::max({most, pattern.size.rows - 1, pattern.size.cols - 1});
  return most;
}

/// Where a point of the lattice lies on the board.
Eigen::Vector2d OnBoard(const Placement& placement, const Eigen::Vector2d& lattice) {
  const Lattice::Window& window = placement.corners;
  const Eigen::Vector2d center(window.x + 0.5 * (window.cols - 1), window.y + 0.5 * (window.rows - 1));
  constexpr std::array<int, 4> kCos{1, 0, -1, 0}, kSin{0, 1, 0, -1};
  const int cos = kCos[static_cast<std::size_t>(placement.turn)], sin = kSin[static_cast<std::size_t>(placement.turn)];
  return (Eigen::Matrix2d() << cos, sin, -sin, cos).finished() * (lattice - center);
}

}  // namespace

BoardFinder::BoardFinder(std::vector<BorderPattern> patterns, ColorSpace space)
    : patterns_(std::move(patterns)), most_corners_(MostCorners(patterns_)), space_(space), judge_(space) {}

float BoardFinder::ContrastOf(const std::vector<Corner>& corners) const {
  float sum = 0, count = 0;
  for (std::size_t i = 0; i < corners.size(); ++i)
    if ((*claimed_)[i]) sum += corners[i].contrast, count += 1;
  return sum / std::max(count, 1.0f);
}

bool BoardFinder::JudgeOpen(Placement& placement) {
  LatticeCells& cells = grid_->cells;
  if (!Accept(placement, ShowsEnough(placement, grid_->footprint))) return false;
  if (Accept(placement, judge_.Judge(grid_->footprint, placement, grid_->work))) return true;
  if (!placement.inks_alike || !cells.small()) return false;
  cells.Unmix(unmixer_);
  cells.Look(placement.corners, grid_->footprint);
  return Accept(placement, ShowsEnough(placement, grid_->footprint)) &&
         Accept(placement, judge_.Judge(grid_->footprint, placement, grid_->work));
}

bool BoardFinder::JudgeCovered(Placement& placement) {
  if (++grid_->with_cover > kMostWithCover) return false;
  // The cover lies where it explains most of what does not show: at another side, the border that is left may match
  // too.
  std::array<std::pair<int, int>, 4> sides;
  for (placement.covered.lines = 1; placement.covered.lines <= kMostCovered; ++placement.covered.lines) {
    for (int side = 0; side < 4; ++side) {
      placement.covered.side = side;
      sides[static_cast<std::size_t>(side)] = {NotShowing(placement, grid_->footprint), side};
    }
    std::sort(sides.begin(), sides.end());
    for (const auto& [not_showing, side] : sides) {
      placement.covered.side = side;
      if (ShowsEnough(placement, grid_->footprint).passed() &&
          judge_.Judge(grid_->footprint, placement, grid_->work).passed())
        return true;
    }
  }
  return false;
}

void BoardFinder::TryWindow(const BorderPattern& pattern, const Lattice::Window& window, bool turned) {
  const MarkerSize size = pattern.size;
  LatticeCells& cells = grid_->cells;
  if (cells.mixed()) {
    // Only where a checkerboard shows: clutter is not worth it.
    cells.Look(window, grid_->footprint);
    const Placement placement{.pattern = &pattern, .corners = window, .covered = {}};
    if (Accept(placement, ShowsEnough(placement, grid_->footprint))) cells.Unmix(unmixer_);
  }
  bool looked = false;
  // A square board's footprint is the same for all turns.
  const int step = size.rows == size.cols ? 1 : 2;
  for (int turn = turned ? 1 : 0; turn < 4; turn += step) {
    Placement placement{.pattern = &pattern, .corners = window, .turn = turn, .covered = {}};
    // The lattice's cell (i, j) is light where i + j is even; the board's first cell is dark.
    const Cell first = InFootprint(size, 0, 0, placement.turn);
    if ((window.x - 1 + first.col + window.y - 1 + first.row) % 2 == 0) continue;
    grid_->work.Add(WorkStep::kWindow);
    const bool may_be = judge_.MayBeBorder(placement, cells);
    if (!may_be && !grid_->attempt) continue;
    if (!looked) cells.Look(window, grid_->footprint);
    looked = true;
    if (!may_be) {
      Accept(placement, {Refusal::kNoYellow});
      continue;
    }
    if (!JudgeOpen(placement) && !JudgeCovered(placement)) continue;
    // The border's period is four cells: turned by half a turn and two cells off, a board with two lines occluded looks
    // the same, but one of its sides lies inside the board in truth.
    if (placement.border_seen < kAllButTwoLines * BorderLength(size) && HasCornersOnItsSides(grid_->lattice, window)) {
      Accept(placement, {Refusal::kGoesOn});
      continue;
    }
    grid_->placements.push_back(placement);
  }
}

int BoardFinder::GatherWindows(const BorderPattern& pattern, Lattice::Window window) {
  const Lattice::Window& all = grid_->lattice.window();
  const double least = std::max<double>(GridLinker::kFewest, kLeastCorners * window.cols * window.rows);
  int most = 0;
  grid_->windows.clear();
  for (window.y = all.y; window.y + window.rows <= all.y + all.rows; ++window.y)
    for (window.x = all.x; window.x + window.cols <= all.x + all.cols; ++window.x) {
      const int count = grid_->lattice.Count(window);
      most = std::max(most, count);
      if (count >= least) grid_->windows.emplace_back(count, window);
    }
  if (grid_->windows.empty())
    Accept({.pattern = &pattern, .corners = {}, .covered = {}},
           {Refusal::kFewCorners, static_cast<double>(most), std::ceil(least)});
  // What is beyond doubt spares the others around it, which have fewer corners for the most part.
  std::sort(grid_->windows.begin(), grid_->windows.end(), [](const auto& a, const auto& b) {
    return std::tuple(-a.first, a.second.y, a.second.x) < std::tuple(-b.first, b.second.y, b.second.x);
  });
  return most;
}

void BoardFinder::TryWindows(const BorderPattern& pattern, bool turned) {
  const MarkerSize size = pattern.size;
  const Lattice::Window& all = grid_->lattice.window();
  const Lattice::Window window{0, 0, (turned ? size.rows : size.cols) - 1, (turned ? size.cols : size.rows) - 1};
  const int most = GatherWindows(pattern, window);
  // A board that is seen in part still has nearly all the corners that there are.
  const bool one_board = all.cols < 2 * window.cols && all.rows < 2 * window.rows;
  if (grid_->limit.waited > 0 && !one_board && !grid_->windows.empty()) {
    const std::uint64_t tried =
        static_cast<std::uint64_t>(grid_->limit.waited) * (grid_->limit.units / kUnitsOfWindow + 1);
    std::rotate(grid_->windows.begin(),
                grid_->windows.begin() + static_cast<std::ptrdiff_t>(tried % grid_->windows.size()),
                grid_->windows.end());
  }
  grid_->spared.assign(static_cast<std::size_t>(all.cols * all.rows), 0);
  grid_->work.Add(WorkStep::kLatticePoint, grid_->spared.size());
  for (const auto& [count, at] : grid_->windows) {
    if (one_board && count <= kLeastOfMost * most) break;
    if (grid_->spared[static_cast<std::size_t>((at.y - all.y) * all.cols + at.x - all.x)]) continue;
    if (grid_->left_undone = work().units() > grid_->limit.units; grid_->left_undone) break;
    const std::size_t before = grid_->placements.size();
    TryWindow(pattern, at, turned);
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
  const int border = BorderLength(placement.pattern->size);
  return grid_->lattice.Count(window) == window.cols * window.rows && placement.border_seen == border &&
         placement.border_matches == border;
}

void BoardFinder::TakeBest(const Lens& lens, std::vector<AnchoredBoard>& boards) {
  grid_->choice.Choose(grid_->placements, grid_->work);
  for (const std::size_t i : grid_->choice.rivalled) Accept(grid_->placements[i], {Refusal::kRivalled});
  for (const std::size_t i : grid_->choice.taken) {
    const Placement& placement = grid_->placements[i];
    if (GoesOn(placement, grid_->placements, grid_->choice, grid_->cells))
      Accept(placement, {Refusal::kGoesOn});
    else if (!Build(placement, lens, boards.emplace_back()))
      boards.pop_back();
  }
}

bool BoardFinder::Build(const Placement& placement, const Lens& lens, AnchoredBoard& board) {
  const Lattice::Window& window = placement.corners;
  LatticeCells& cells = grid_->cells;
  board.size = placement.pattern->size;
  if (cells.on_plane() && grid_->lattice.Count(window) == grid_->lattice.Count(grid_->lattice.window())) {
    // The same corners, which were fitted already.
    grid_->pairs = grid_->all_pairs;
  } else {
    const auto homography = grid_->lattice.Fit(window, &grid_->pairs);
    if (!homography) return Accept(placement, {Refusal::kNotPlane});
    cells.Refine(*homography);
  }
  cells.Resample(window);
  Placement judged = placement;
  // Of the same samples, it would be judged as before.
  if (!(cells.on_plane() && window == grid_->footprint.window)) {
    cells.Look(window, grid_->footprint);
    if (!Accept(judged, judge_.Judge(grid_->footprint, judged, grid_->work))) return false;
  }
  grid_->work.Add(WorkStep::kBoard);
  judge_.Describe(judged, grid_->footprint, board);
  for (const PointPair& pair : grid_->pairs)
    board.box.Add(static_cast<float>(pair.to.x()), static_cast<float>(pair.to.y()));
  board.box.Widen(1.0f / static_cast<float>(std::min(window.cols, window.rows)));
  if (!PlaceOnPlane(placement, lens, board)) return Accept(placement, {Refusal::kNotPlane});
  ClaimCorners(placement, board);
  return true;
}

bool BoardFinder::PlaceOnPlane(const Placement& placement, const Lens& lens, AnchoredBoard& board) {
  const Lattice::Window& window = placement.corners;
  // Where all corners agree, what the lens does to a few points of their homography tells as much as to all of them.
  if (static_cast<int>(grid_->pairs.size()) == window.cols * window.rows) {
    grid_->pairs.clear();
    for (const double y : {0.0, 0.5, 1.0})
      for (const double x : {0.0, 0.5, 1.0}) {
        const Eigen::Vector2d at(window.x + x * (window.cols - 1), window.y + y * (window.rows - 1));
        grid_->pairs.push_back({at, (grid_->cells.image_from_lattice() * at.homogeneous()).hnormalized()});
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
  grid_->scales.clear();
  for (int y = window.y; y < window.y + window.rows; ++y)
    for (int x = window.x; x < window.x + window.cols; ++x)
      if (const Lattice::Point* point = grid_->lattice.At(x, y)) {
        grid_->scales.push_back(point->scale);
        (*claimed_)[static_cast<std::size_t>(point->corner)] = 1;
        const Eigen::Vector2d at = OnBoard(placement, Eigen::Vector2d(x, y));
        const int row = static_cast<int>(std::lround(at.y() + 0.5 * (board.size.rows - 2))),
                  col = static_cast<int>(std::lround(at.x() + 0.5 * (board.size.cols - 2)));
        board.found[static_cast<std::size_t>(row * (board.size.cols - 1) + col)] = true;
      }
  board.scale = MedianInPlace(grid_->scales);
}

bool BoardFinder::Find(const Grid& grid, std::span<const LatticeCorner> members, const std::vector<Corner>& corners,
                       const CornerSearch* search, const LightReader& reader, const Lens& lens,
                       std::vector<AnchoredBoard>& boards, TraceCandidate* attempt, const GridLimit& limit) {
  grid_.Start().attempt = attempt;
  grid_->limit = limit;
  if (!grid_->lattice.Read(grid, members, corners, search, *claimed_, reader.width(), reader.height(), most_corners_))
    return Accept({.corners = {}, .covered = {}}, {Refusal::kNotOneLattice});
  grid_->cells.Start(grid_->lattice, reader);
  // A grid that fits into a board, more or less, lies on one plane.
  if (grid.max_x - grid.min_x + 1 <= most_corners_ + 2 && grid.max_y - grid.min_y + 1 <= most_corners_ + 2)
    if (const auto homography = grid_->lattice.Fit(grid_->lattice.window(), &grid_->all_pairs))
      grid_->cells.PlaceOnPlane(*homography);
  for (const BorderPattern& pattern : patterns_)
    for (const bool turned : {false, true})
      if (!turned || pattern.size.rows != pattern.size.cols) TryWindows(pattern, turned);
  const std::size_t before = boards.size();
  TakeBest(lens, boards);
  return boards.size() > before;
}

}  // namespace chequer
