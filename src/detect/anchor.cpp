#include "detect/anchor.h"

#include <algorithm>
#include <cmath>

#include "detect/colours.h"

namespace chequer {
namespace {

/// Larger grids are no boards: a wall of tiles.
constexpr int kMostLattice = 160;
/// Least corners of a placement that were found, of all it has.
constexpr double kLeastCorners = 0.3;
/// Least share of cells that must be seen as lighter or darker than their neighbours.
constexpr double kLeastVisible = 0.5;
/// Border: least cells judged, least share that matches.
constexpr int kLeastBorder = 9;
constexpr double kLeastMatches = 0.85;
/// How much a placement must beat those it overlaps with.
constexpr double kLeastLead = 3;
/// Distance between the group means over its standard error, each of light and dark cells.
constexpr double kLeastSeparation = 4;

/// Cell (row, col) of the board in the footprint's own rows and columns, for a board turned by quarter turns.
Cell InFootprint(MarkerSize size, int row, int col, int turn) {
  switch (turn) {
    case 0: return {row, col};
    case 1: return {col, size.rows - 1 - row};  // the board's columns run down
    case 2: return {size.rows - 1 - row, size.cols - 1 - col};
    default: return {size.cols - 1 - col, row};
  }
}

}  // namespace

BorderPattern::BorderPattern(MarkerSize marker_size)
    : size(marker_size), cells(BorderCells(marker_size)), saturated(BorderSaturation(marker_size)) {}

BoardFinder::BoardFinder(std::vector<BorderPattern> patterns, ColorSpace space)
    : patterns_(std::move(patterns)), space_(space) {}

bool BoardFinder::MapLattice(const Grid& grid, std::span<const LatticeCorner> lattice,
                             const std::vector<Corner>& corners, const Lens& lens) {
  min_x_ = grid.min_x;
  min_y_ = grid.min_y;
  width_ = grid.max_x - grid.min_x + 1;
  height_ = grid.max_y - grid.min_y + 1;
  if (width_ > kMostLattice || height_ > kMostLattice) return false;
  map_.assign(static_cast<std::size_t>(width_ * height_), -1);
  positions_.clear();
  scales_.clear();
  for (const LatticeCorner& at : lattice) {
    int& slot = map_[static_cast<std::size_t>((at.y - min_y_) * width_ + at.x - min_x_)];
    if (slot >= 0) continue;
    const Corner& corner = corners[static_cast<std::size_t>(at.corner)];
    const auto plane = lens.ToPlane(corner.position.cast<double>());
    if (!plane) continue;
    slot = static_cast<int>(positions_.size());
    positions_.push_back(*plane);
    scales_.push_back(corner.scale);
  }
  return true;
}

bool BoardFinder::FitFootprint(int x, int y, int cols, int rows) {
  pairs_.clear();
  for (int dy = 0; dy < rows; ++dy)
    for (int dx = 0; dx < cols; ++dx)
      if (const int i = At(x + dx, y + dy); i >= 0)
        pairs_.push_back({{dx + 1.0, dy + 1.0}, positions_[static_cast<std::size_t>(i)]});
  if (pairs_.size() < GridLinker::kFewest || static_cast<double>(pairs_.size()) < kLeastCorners * cols * rows) {
    return false;
  }
  const bool all = pairs_.size() == positions_.size();
  const Eigen::Vector2d shift(x - 1, y - 1);  // lattice from footprint
  const Eigen::Matrix3d lattice_from_footprint =
      (Eigen::Matrix3d() << 1, 0, shift.x(), 0, 1, shift.y(), 0, 0, 1).finished();
  if (all && shared_) {
    if (!shared_fits_) return false;
    plane_from_lattice_ = plane_from_shared_ * lattice_from_footprint;
    pairs_ = shared_pairs_;
    for (PointPair& pair : pairs_) pair.from -= shift;
    return true;
  }
  const bool fits = FitPairs(cols, rows);
  if (all) {
    shared_ = true;
    shared_fits_ = fits;
    plane_from_shared_ = plane_from_lattice_ * lattice_from_footprint.inverse();
    shared_pairs_ = pairs_;
    for (PointPair& pair : shared_pairs_) pair.from += shift;
  } else {
    std::fill(cached_.begin(), cached_.end(), std::uint8_t{0});
    shared_ = false;
  }
  return fits;
}

bool BoardFinder::FitPairs(int cols, int rows) {
  // A corner that does not belong is found by how far it lies off the others' homography.
  for (int attempt = 0; attempt < 3; ++attempt) {
    const auto homography = FitHomography(pairs_);
    if (!homography) return false;
    plane_from_lattice_ = *homography;
    double worst = 0;
    std::size_t worst_index = 0;
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const double error = ((*homography * pairs_[i].from.homogeneous()).hnormalized() - pairs_[i].to).norm();
      if (error > worst) worst = error, worst_index = i;
    }
    const Eigen::Vector2d center(cols / 2.0 + 0.5, rows / 2.0 + 0.5);
    const double cell = ((*homography * (center + Eigen::Vector2d(0.5, 0)).homogeneous()).hnormalized() -
                         (*homography * (center - Eigen::Vector2d(0.5, 0)).homogeneous()).hnormalized())
                            .norm();
    if (worst < std::max(0.25 * cell, 1.0)) return true;
    if (pairs_.size() <= GridLinker::kFewest) return false;
    pairs_.erase(pairs_.begin() + static_cast<std::ptrdiff_t>(worst_index));
  }
  return false;
}

void BoardFinder::SampleCells(int x, int y, int cols, int rows, const LightReader& reader, const Lens& lens) {
  samples_.assign(static_cast<std::size_t>(cols * rows), CellSample{});
  const auto image_at = [&](double col, double row) -> Eigen::Vector2d {
    return lens.ToImage((plane_from_lattice_ * Eigen::Vector3d(col, row, 1)).hnormalized());
  };
  // The short side of a cell tells how much of it is clear of its neighbours.
  const Eigen::Vector2d center = image_at(cols / 2.0, rows / 2.0);
  const Eigen::Vector2d along_x = image_at(cols / 2.0 + 0.5, rows / 2.0) - center,
                        along_y = image_at(cols / 2.0, rows / 2.0 + 0.5) - center;
  const double area = std::abs(along_x.x() * along_y.y() - along_x.y() * along_y.x());
  const double half = 0.5 * area / std::max({along_x.norm(), along_y.norm(), 1e-9});
  const float half_px = static_cast<float>(std::clamp(half, 0.0, 3.0));
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col) {
      CellSample& sample = samples_[static_cast<std::size_t>(row * cols + col)];
      const int at_x = x - 1 + col - cache_x_, at_y = y - 1 + row - cache_y_;
      const std::size_t slot = static_cast<std::size_t>(at_y * cache_cols_ + at_x);
      if (cached_[slot]) {
        sample = cache_[slot];
        continue;
      }
      const Eigen::Vector2d p = image_at(col + 0.5, row + 0.5);
      sample.inside = p.x() >= 0 && p.y() >= 0 && p.x() <= reader.width() - 1 && p.y() <= reader.height() - 1;
      if (sample.inside) sample.light = reader.Rgb(static_cast<float>(p.x()), static_cast<float>(p.y()), half_px);
      cache_[slot] = sample;
      cached_[slot] = 1;
    }
}

void BoardFinder::MarkVisible(int cols, int rows) {
  // How much lighter each cell is than its neighbours, in the measure that knows blue from black least. The sign is
  // that of the cell's class where the board is in view.
  lead_.assign(samples_.size(), 0.0f);
  std::vector<float> sizes;
  sizes.reserve(samples_.size());
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col) {
      const auto value = [&](int r, int c) {
        const Eigen::Vector3f& light = samples_[static_cast<std::size_t>(r * cols + c)].light;
        return std::sqrt(std::max(light[0] + light[1], 0.0f));
      };
      float sum = 0;
      int count = 0;
      for (const auto& [dr, dc] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        const int r = row + dr, c = col + dc;
        if (r < 0 || c < 0 || r >= rows || c >= cols || !samples_[static_cast<std::size_t>(r * cols + c)].inside)
          continue;
        sum += value(r, c);
        ++count;
      }
      const float difference = count ? value(row, col) - sum / static_cast<float>(count) : 0;
      lead_[static_cast<std::size_t>(row * cols + col)] = difference;
      sizes.push_back(std::abs(difference));
    }
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 2 / 3), sizes.end());
  const float least = 0.3f * sizes[sizes.size() * 2 / 3];
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    samples_[i].visible = samples_[i].inside && std::abs(lead_[i]) > least;
  }
}

bool BoardFinder::JudgeBorder(Placement& placement, AnchoredBoard* board) const {
  const BorderPattern& pattern = patterns_[static_cast<std::size_t>(placement.pattern)];
  const MarkerSize size = pattern.size;
  const int cols = placement.turn % 2 == 0 ? size.cols : size.rows;
  const auto index = [&](int row, int col) {
    const Cell cell = InFootprint(size, row, col, placement.turn);
    return static_cast<std::size_t>(cell.row * cols + cell.col);
  };
  const auto visible = [&](int row, int col) {
    const std::size_t i = index(row, col);
    return samples_[i].visible && (lead_[i] < 0) == IsDark(row, col);
  };
  if (board) {
    board->light.resize(static_cast<std::size_t>(size.rows * size.cols));
    board->saturated.assign(board->light.size(), 0);
    for (int row = 0; row < size.rows; ++row)
      for (int col = 0; col < size.cols; ++col)
        board->light[static_cast<std::size_t>(row * size.cols + col)] = samples_[index(row, col)].light;
  }
  int seen = 0;
  for (int row = 0; row < size.rows; ++row)
    for (int col = 0; col < size.cols; ++col) seen += visible(row, col);
  if (seen < kLeastVisible * size.rows * size.cols) return false;

  // White, by the border cells that are white if this turn is right.
  Eigen::Vector3f white = Eigen::Vector3f::Zero();
  int whites = 0;
  for (std::size_t k = 0; k < pattern.cells.size(); ++k) {
    const Cell& cell = pattern.cells[k];
    if (IsDark(cell.row, cell.col) || pattern.saturated[k] || !visible(cell.row, cell.col)) continue;
    white += samples_[index(cell.row, cell.col)].light;
    ++whites;
  }
  if (whites < 2) return false;
  white /= static_cast<float>(whites);
  if (!(white.minCoeff() > 1e-5f)) return false;

  const auto saturation = [&](int row, int col) {
    return ColourOf(samples_[index(row, col)].light, white, IsDark(row, col), space_).saturation;
  };
  // Group means of eq. 4, apart for light and dark cells, whose inks differ in strength.
  std::array<std::array<GaussianSum, 2>, 2> groups;  // [dark][saturated]
  std::vector<std::pair<std::size_t, float>> values;
  values.reserve(pattern.cells.size());
  for (std::size_t k = 0; k < pattern.cells.size(); ++k) {
    const Cell& cell = pattern.cells[k];
    if (!visible(cell.row, cell.col)) continue;
    const float value = saturation(cell.row, cell.col);
    values.emplace_back(k, value);
    groups[IsDark(cell.row, cell.col)][pattern.saturated[k]].Add(value);
  }
  if (static_cast<int>(values.size()) < std::min(kLeastBorder, BorderLength(size))) return false;
  std::array<double, 2> threshold{};
  for (std::size_t dark = 0; dark < 2; ++dark) {
    const Gaussian plain = groups[dark][0].Get(), inked = groups[dark][1].Get();
    if (plain.count < 2 || inked.count < 2) return false;
    const double error = std::sqrt((plain.deviation * plain.deviation + 0.25) / plain.count +
                                   (inked.deviation * inked.deviation + 0.25) / inked.count);
    if (inked.mean - plain.mean < kLeastSeparation * error) return false;
    threshold[dark] = (plain.mean + inked.mean) / 2;
  }
  int matches = 0;
  for (const auto& [k, value] : values) {
    const Cell& cell = pattern.cells[k];
    matches += (value > threshold[IsDark(cell.row, cell.col)]) == (pattern.saturated[k] != 0);
  }
  placement.border_seen = static_cast<int>(values.size());
  placement.border_matches = matches;
  placement.score = 2 * matches - placement.border_seen + 0.25 * seen;
  if (matches < kLeastMatches * placement.border_seen) return false;
  if (board) {
    for (int row = 0; row < size.rows; ++row)
      for (int col = 0; col < size.cols; ++col) {
        const std::size_t cell = static_cast<std::size_t>(row * size.cols + col);
        board->saturated[cell] = saturation(row, col) > threshold[IsDark(row, col)];
      }
  }
  return true;
}

void BoardFinder::TryFootprint(int pattern, int x, int y, bool turned, const LightReader& reader, const Lens& lens) {
  const MarkerSize size = patterns_[static_cast<std::size_t>(pattern)].size;
  const int cols = turned ? size.rows : size.cols, rows = turned ? size.cols : size.rows;
  if (!FitFootprint(x, y, cols - 1, rows - 1)) return;
  SampleCells(x, y, cols, rows, reader, lens);
  MarkVisible(cols, rows);
  // A square board's footprint is the same for all turns.
  const int step = size.rows == size.cols ? 1 : 2;
  for (int turn = turned ? 1 : 0; turn < 4; turn += step) {
    Placement placement{.pattern = pattern, .x = x, .y = y, .turn = turn};
    // The lattice's cell (i, j) is light where i + j is even; the board's first cell is dark.
    const Cell first = InFootprint(size, 0, 0, placement.turn);
    if ((x - 1 + first.col + y - 1 + first.row) % 2 == 0) continue;
    if (JudgeBorder(placement, nullptr)) placements_.push_back(placement);
  }
}

AnchoredBoard BoardFinder::Build(const Placement& placement, const LightReader& reader, const Lens& lens) {
  const BorderPattern& pattern = patterns_[static_cast<std::size_t>(placement.pattern)];
  const MarkerSize size = pattern.size;
  const bool turned = placement.turn % 2 == 1;
  const int cols = turned ? size.rows : size.cols, rows = turned ? size.cols : size.rows;
  AnchoredBoard board;
  board.size = size;
  FitFootprint(placement.x, placement.y, cols - 1, rows - 1);
  SampleCells(placement.x, placement.y, cols, rows, reader, lens);
  MarkVisible(cols, rows);
  Placement judged = placement;
  JudgeBorder(judged, &board);
  board.border_seen = judged.border_seen;
  board.border_matches = judged.border_matches;
  // Footprint coordinates of board points: a rotation about the centre.
  Eigen::Matrix3d footprint_from_board = Eigen::Matrix3d::Identity();
  constexpr std::array<int, 4> kCos{1, 0, -1, 0}, kSin{0, 1, 0, -1};
  const std::size_t turn = static_cast<std::size_t>(placement.turn);
  footprint_from_board << kCos[turn], -kSin[turn], cols / 2.0, kSin[turn], kCos[turn], rows / 2.0, 0, 0, 1;
  board.plane_from_board = plane_from_lattice_ * footprint_from_board;
  const Eigen::Matrix2d back = footprint_from_board.topLeftCorner<2, 2>().transpose();
  board.pairs.clear();
  for (const PointPair& pair : pairs_)
    board.pairs.push_back({back * (pair.from - Eigen::Vector2d(cols / 2.0, rows / 2.0)), pair.to});
  std::vector<float> scales;
  for (int dy = 0; dy < rows - 1; ++dy)
    for (int dx = 0; dx < cols - 1; ++dx)
      if (const int i = At(placement.x + dx, placement.y + dy); i >= 0)
        scales.push_back(scales_[static_cast<std::size_t>(i)]);
  std::nth_element(scales.begin(), scales.begin() + static_cast<std::ptrdiff_t>(scales.size() / 2), scales.end());
  board.scale = scales[scales.size() / 2];
  return board;
}

void BoardFinder::TakeBest(const LightReader& reader, const Lens& lens, std::vector<AnchoredBoard>& boards) {
  std::sort(placements_.begin(), placements_.end(),
            [](const Placement& a, const Placement& b) { return a.score > b.score; });
  const auto overlap = [&](const Placement& a, const Placement& b) {
    const MarkerSize sa = patterns_[static_cast<std::size_t>(a.pattern)].size,
                     sb = patterns_[static_cast<std::size_t>(b.pattern)].size;
    const int ac = a.turn % 2 ? sa.rows : sa.cols, ar = a.turn % 2 ? sa.cols : sa.rows;
    const int bc = b.turn % 2 ? sb.rows : sb.cols, br = b.turn % 2 ? sb.cols : sb.rows;
    return a.x < b.x + bc && b.x < a.x + ac && a.y < b.y + br && b.y < a.y + ar;
  };
  std::vector<std::size_t> taken;
  for (std::size_t i = 0; i < placements_.size(); ++i) {
    const auto overlaps_taken = [&](std::size_t k) {
      return std::any_of(taken.begin(), taken.end(),
                         [&](std::size_t t) { return overlap(placements_[t], placements_[k]); });
    };
    if (overlaps_taken(i)) continue;
    bool rivalled = false;
    for (std::size_t k = i + 1; k < placements_.size() && !rivalled; ++k)
      rivalled = placements_[k].score > placements_[i].score - kLeastLead && overlap(placements_[i], placements_[k]) &&
                 !overlaps_taken(k);
    if (rivalled) continue;
    taken.push_back(i);
    boards.push_back(Build(placements_[i], reader, lens));
  }
}

bool BoardFinder::Find(const Grid& grid, std::span<const LatticeCorner> lattice, const std::vector<Corner>& corners,
                       const LightReader& reader, const Lens& lens, std::vector<AnchoredBoard>& boards) {
  if (!MapLattice(grid, lattice, corners, lens)) return false;
  placements_.clear();
  shared_ = false;
  // Cells that any footprint may reach.
  int most = 0;
  for (const BorderPattern& pattern : patterns_) most = std::max({most, pattern.size.rows, pattern.size.cols});
  cache_x_ = min_x_ - most - 1;
  cache_y_ = min_y_ - most - 1;
  cache_cols_ = width_ + 2 * most + 3;
  cache_rows_ = height_ + 2 * most + 3;
  cache_.resize(static_cast<std::size_t>(cache_cols_ * cache_rows_));
  cached_.assign(cache_.size(), 0);
  for (int pattern = 0; pattern < static_cast<int>(patterns_.size()); ++pattern) {
    const MarkerSize size = patterns_[static_cast<std::size_t>(pattern)].size;
    for (const bool turned : {false, true}) {
      if (turned && size.rows == size.cols) continue;
      // In lattice corners.
      const int cols = (turned ? size.rows : size.cols) - 1, rows = (turned ? size.cols : size.rows) - 1;
      const int max_x = grid.max_x - cols + 1, max_y = grid.max_y - rows + 1;
      for (int y = std::min(grid.min_y, max_y); y <= std::max(grid.min_y, max_y); ++y)
        for (int x = std::min(grid.min_x, max_x); x <= std::max(grid.min_x, max_x); ++x)
          TryFootprint(pattern, x, y, turned, reader, lens);
    }
  }
  const std::size_t before = boards.size();
  TakeBest(reader, lens, boards);
  return boards.size() > before;
}

}  // namespace chequer
