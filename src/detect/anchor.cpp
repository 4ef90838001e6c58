#include "detect/anchor.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

#include "core/median.h"

namespace chequer {
namespace {

/// Least share of a board's corners that were found.
constexpr double kLeastCorners = 0.38;
/// Least share of the corners of the window that has the most.
constexpr double kLeastOfMost = 0.8;
/// With less of the border to be seen than that share, two lines of cells may be hidden.
constexpr double kAllButTwoLines = 0.66;

}  // namespace

BoardFinder::BoardFinder(std::vector<BorderPattern> patterns, ColorSpace space)
    : patterns_(std::move(patterns)), space_(space) {
  for (const BorderPattern& pattern : patterns_)
    most_corners_ = std::max({most_corners_, pattern.size.rows - 1, pattern.size.cols - 1});
}

void BoardFinder::Start(std::size_t corners, std::vector<AnchoredBoard>& boards) {
  claimed_.assign(corners, 0);
  std::move(boards.begin(), boards.end(), std::back_inserter(spare_));
  boards.clear();
}

float BoardFinder::ContrastOf(const std::vector<Corner>& corners) const {
  float sum = 0, count = 0;
  for (std::size_t i = 0; i < corners.size(); ++i)
    if (claimed_[i]) sum += corners[i].contrast, count += 1;
  return sum / std::max(count, 1.0f);
}

AnchoredBoard BoardFinder::TakeSpare() {
  if (spare_.empty()) return {};
  AnchoredBoard board = std::move(spare_.back());
  spare_.pop_back();
  return board;
}

bool BoardFinder::FitWindow(const Lattice::Window& window, std::vector<PointPair>* pairs) {
  const auto homography = lattice_.Fit(window, pairs);
  if (!homography) return false;
  image_from_lattice_ = *homography;
  return true;
}

void BoardFinder::TryWindow(int pattern, const Lattice::Window& window, bool turned, const LightReader& reader) {
  const MarkerSize size = patterns_[static_cast<std::size_t>(pattern)].size;
  bool marked = false;
  // A square board's footprint is the same for all turns.
  const int step = size.rows == size.cols ? 1 : 2;
  for (int turn = turned ? 1 : 0; turn < 4; turn += step) {
    Placement placement{.pattern = pattern, .corners = window, .turn = turn, .covered = {}};
    // The lattice's cell (i, j) is light where i + j is even; the board's first cell is dark.
    const Cell first = InFootprint(size, 0, 0, placement.turn);
    if ((window.x - 1 + first.col + window.y - 1 + first.row) % 2 == 0) continue;
    const bool may_be = MayBeBorder(patterns_[static_cast<std::size_t>(pattern)], window, turn, reader);
    if (!may_be && !attempt_) continue;
    if (!marked) MarkVisible(window, reader);
    marked = true;
    if (!may_be) {
      Refuse(placement, Refusal::kNoYellow, 0, 0);
      continue;
    }
    if (!(ShowsEnough(placement) && JudgeBorder(placement)) && !JudgeCovered(placement)) continue;
    // The border's period is four cells: turned by half a turn and two cells off, a board with two lines hidden looks
    // the same, but one of its sides lies inside the board in truth.
    if (placement.border_seen < kAllButTwoLines * BorderLength(size) && HasCornersOnItsSides(window)) {
      Refuse(placement, Refusal::kGoesOn, 0, 0);
      continue;
    }
    placements_.push_back(placement);
  }
}

void BoardFinder::TryWindows(int pattern, bool turned, const LightReader& reader) {
  const MarkerSize size = patterns_[static_cast<std::size_t>(pattern)].size;
  const Lattice::Window& all = lattice_.window();
  windows_.clear();
  Lattice::Window window{0, 0, (turned ? size.rows : size.cols) - 1, (turned ? size.cols : size.rows) - 1};
  const double least = std::max<double>(GridLinker::kFewest, kLeastCorners * window.cols * window.rows);
  int most = 0;
  for (window.y = all.y; window.y + window.rows <= all.y + all.rows; ++window.y)
    for (window.x = all.x; window.x + window.cols <= all.x + all.cols; ++window.x) {
      const int count = lattice_.Count(window);
      most = std::max(most, count);
      if (count >= least) windows_.emplace_back(count, window);
    }
  if (windows_.empty())
    Refuse({.pattern = pattern, .corners = {}, .covered = {}}, Refusal::kFewCorners, most, std::ceil(least));
  // A board that is seen in part still has nearly all the corners that there are.
  const bool one_board = all.cols < 2 * window.cols && all.rows < 2 * window.rows;
  // What is beyond doubt spares the others around it, which have fewer corners for the most part.
  std::sort(windows_.begin(), windows_.end(), [](const auto& a, const auto& b) {
    return std::tuple(-a.first, a.second.y, a.second.x) < std::tuple(-b.first, b.second.y, b.second.x);
  });
  const std::size_t before = placements_.size();
  for (const auto& counted : windows_) {
    if (one_board && counted.first <= kLeastOfMost * most) break;
    const Lattice::Window& at = counted.second;
    const bool is_spared =
        std::any_of(placements_.begin() + static_cast<std::ptrdiff_t>(before), placements_.end(),
                    [&](const Placement& other) { return IsBeyondDoubt(other) && SharesCells(other.corners, at); });
    if (!is_spared) TryWindow(pattern, at, turned, reader);
  }
}

bool BoardFinder::IsBeyondDoubt(const Placement& placement) const {
  const Lattice::Window& window = placement.corners;
  const int border = BorderLength(patterns_[static_cast<std::size_t>(placement.pattern)].size);
  return lattice_.Count(window) == window.cols * window.rows && placement.border_seen == border &&
         placement.border_matches == border;
}

bool BoardFinder::Build(const Placement& placement, const LightReader& reader, const Lens& lens, AnchoredBoard& board) {
  const BorderPattern& pattern = patterns_[static_cast<std::size_t>(placement.pattern)];
  const Lattice::Window& window = placement.corners;
  board.size = pattern.size;
  if (shared_ && lattice_.Count(window) == lattice_.Count(lattice_.window())) {
    // The same corners, which were fitted already.
    pairs_ = shared_pairs_;
  } else if (!FitWindow(window, &pairs_)) {
    return Refuse(placement, Refusal::kNotPlane, 0, 0);
  }
  ResampleByHomography(window, reader);
  Placement judged = placement;
  // Of the same samples, it would be judged as before.
  if (!(shared_ && window == marked_)) {
    MarkVisible(window, reader);
    if (!JudgeBorder(judged)) return false;
  }
  DescribeCells(judged, board);
  board.border_seen = judged.border_seen;
  board.border_matches = judged.border_matches;
  // Board coordinates: from the footprint's centre, turned.
  const Eigen::Vector2d center(window.x + 0.5 * (window.cols - 1), window.y + 0.5 * (window.rows - 1));
  constexpr std::array<int, 4> kCos{1, 0, -1, 0}, kSin{0, 1, 0, -1};
  const int cos = kCos[static_cast<std::size_t>(placement.turn)], sin = kSin[static_cast<std::size_t>(placement.turn)];
  const Eigen::Matrix2d board_from_lattice = (Eigen::Matrix2d() << cos, sin, -sin, cos).finished();
  board.box = {};
  for (const PointPair& pair : pairs_) board.box.Add(static_cast<float>(pair.to.x()), static_cast<float>(pair.to.y()));
  // Where all corners agree, what the lens does to a few points of their homography tells as much as to all of them.
  if (static_cast<int>(pairs_.size()) == window.cols * window.rows) {
    pairs_.clear();
    for (const double y : {0.0, 0.5, 1.0})
      for (const double x : {0.0, 0.5, 1.0}) {
        const Eigen::Vector2d at(window.x + x * (window.cols - 1), window.y + y * (window.rows - 1));
        pairs_.push_back({at, (image_from_lattice_ * at.homogeneous()).hnormalized()});
      }
  }
  for (PointPair& pair : pairs_) {
    pair.from = board_from_lattice * (pair.from - center);
    const auto plane = lens.ToPlane(pair.to);
    if (!plane) return Refuse(placement, Refusal::kNotPlane, 0, 0);
    pair.to = *plane;
  }
  board.box.Widen(1.0f / static_cast<float>(std::min(window.cols, window.rows)));
  const auto homography = FitHomography(pairs_);
  if (!homography) return Refuse(placement, Refusal::kNotPlane, 0, 0);
  board.plane_from_board = *homography;
  sorted_.clear();
  board.found.fill(false);
  for (int y = window.y; y < window.y + window.rows; ++y)
    for (int x = window.x; x < window.x + window.cols; ++x)
      if (const Lattice::Point* point = lattice_.At(x, y)) {
        sorted_.push_back(point->scale);
        claimed_[static_cast<std::size_t>(point->corner)] = 1;
        const Eigen::Vector2d at = board_from_lattice * (Eigen::Vector2d(x, y) - center);
        const int row = static_cast<int>(std::lround(at.y() + 0.5 * (pattern.size.rows - 2))),
                  col = static_cast<int>(std::lround(at.x() + 0.5 * (pattern.size.cols - 2)));
        board.found[static_cast<std::size_t>(row * (pattern.size.cols - 1) + col)] = true;
      }
  board.scale = MedianInPlace(sorted_);
  return true;
}

bool BoardFinder::Find(const Grid& grid, std::span<const LatticeCorner> members, const std::vector<Corner>& corners,
                       const CornerSearch* search, const LightReader& reader, const Lens& lens,
                       std::vector<AnchoredBoard>& boards) {
  if (!lattice_.Read(grid, members, corners, search, claimed_, reader.width(), reader.height(), most_corners_))
    return Refuse({.corners = {}, .covered = {}}, Refusal::kNotOneLattice, 0, 0);
  placements_.clear();
  taken_.clear();
  const Lattice::Window& all = lattice_.window();
  cell_window_ = {all.x - 2, all.y - 2, all.cols + 3, all.rows + 3};
  cells_.assign(static_cast<std::size_t>(cell_window_.cols * cell_window_.rows), CellSample{});
  // A grid that fits into a board, more or less, lies on one plane.
  const int cols = grid.max_x - grid.min_x + 1, rows = grid.max_y - grid.min_y + 1;
  shared_ = cols <= most_corners_ + 2 && rows <= most_corners_ + 2 && FitWindow(all, &shared_pairs_);
  marked_ = {};
  for (int pattern = 0; pattern < static_cast<int>(patterns_.size()); ++pattern) {
    const MarkerSize size = patterns_[static_cast<std::size_t>(pattern)].size;
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
