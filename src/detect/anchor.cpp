#include "detect/anchor.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "detect/colours.h"
#include "detect/cover.h"

namespace chequer {
namespace {

/// Least share of a board's corners that were found.
constexpr double kLeastCorners = 0.38;
/// Least share of the corners of the window that has the most.
constexpr double kLeastOfMost = 0.8;
/// Least share of cells that must be seen as lighter or darker than their neighbours.
constexpr double kLeastVisible = 0.5;
/// The same of a board that something lies over, of the other cells.
constexpr double kLeastVisibleBesides = 0.8;
/// Border: least cells judged, least share that matches.
constexpr int kLeastBorder = 9;
constexpr double kLeastMatches = 0.85;
/// With less of the border to be seen than that share, two lines of cells may be hidden.
constexpr double kAllButTwoLines = 0.66;
/// Share of a line of the lattice that holds corners if it lies inside a checkerboard for sure.
constexpr double kLeastOfLine = 1;
/// A side of a window goes on if at least this share of the cells beyond it are like those inside it, to so much of the
/// contrast; with so many sides that do,
/// the window is a part of a larger board.
constexpr double kLeastAlike = 0.8;
constexpr float kAlike = 0.35f;
constexpr int kMostSides = 2;
/// Half the side of the square that tells a cell's light: as a share of the cell, and at most so many pixels.
constexpr double kSampledShare = 0.3, kMostSampledPx = 2.5;
/// Lines of cells along one side that something may lie over.
constexpr int kMostCovered = 2;
/// How much less blue yellow cells return than white ones to be looked at: as a share of their light, and in standard
/// deviations of the difference.
constexpr float kLeastBlueDifference = 0.004f, kLeastBlueLead = 2;
/// How much a placement must beat those it overlaps with.
constexpr double kLeastLead = 3;
/// Distance between the group means over its standard error, each of light and dark cells.
constexpr double kLeastSeparation = 4;

/// Reorders the values.
float Median(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Cell InFootprint(MarkerSize size, int row, int col, int turn) {
  switch (turn) {
    case 0: return {row, col};
    case 1: return {col, size.rows - 1 - row};  // the board's columns run down
    case 2: return {size.rows - 1 - row, size.cols - 1 - col};
    default: return {size.cols - 1 - col, row};
  }
}

BorderPattern::BorderPattern(MarkerSize marker_size)
    : size(marker_size), cells(BorderCells(marker_size)), saturated(BorderSaturation(marker_size)) {
  for (int turn = 0; turn < 4; ++turn)
    for (std::size_t k = 0; k < cells.size(); ++k)
      if (!IsDark(cells[k].row, cells[k].col))
        light_cells[static_cast<std::size_t>(turn)].emplace_back(InFootprint(size, cells[k].row, cells[k].col, turn),
                                                                 saturated[k]);
}

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

std::optional<BoardFinder::Place> BoardFinder::PlaceByHomography(int x, int y) const {
  const auto image_at = [&](double u, double v) -> Eigen::Vector2d {
    return (image_from_lattice_ * Eigen::Vector3d(u, v, 1)).hnormalized();
  };
  Place place{image_at(x + 0.5, y + 0.5), 0};
  const Eigen::Vector2d along_x = image_at(x + 1.0, y + 0.5) - place.center,
                        along_y = image_at(x + 0.5, y + 1.0) - place.center;
  const double area = std::abs(along_x.x() * along_y.y() - along_x.y() * along_y.x());
  place.side = 2 * area / std::max({along_x.norm(), along_y.norm(), 1e-9});
  return place;
}

std::optional<BoardFinder::Place> BoardFinder::PlaceByNeighbours(int x, int y) const {
  const std::array<const Lattice::Point*, 4> around{lattice_.At(x, y), lattice_.At(x + 1, y), lattice_.At(x + 1, y + 1),
                                                    lattice_.At(x, y + 1)};
  // Between opposite corners.
  for (const std::size_t k : {0u, 1u})
    if (around[k] && around[k + 2]) {
      const Eigen::Vector2d diagonal = around[k + 2]->image - around[k]->image;
      return Place{(around[k]->image + around[k + 2]->image) / 2, diagonal.norm() * std::numbers::sqrt2 / 2};
    }
  // Beyond an edge, which the lattice has to its left when it goes round by growing angle.
  for (std::size_t k = 0; k < 4; ++k)
    if (around[k] && around[(k + 1) % 4]) {
      const Eigen::Vector2d edge = around[(k + 1) % 4]->image - around[k]->image;
      return Place{(around[k]->image + around[(k + 1) % 4]->image) / 2 + Eigen::Vector2d(-edge.y(), edge.x()) / 2,
                   edge.norm()};
    }
  return std::nullopt;
}

void BoardFinder::SampleCell(int x, int y, const LightReader& reader, CellSample& sample) const {
  sample.sampled = true;
  const std::optional<Place> place = shared_ ? PlaceByHomography(x, y) : PlaceByNeighbours(x, y);
  sample.inside = place && place->center.x() >= 0 && place->center.y() >= 0 &&
                  place->center.x() <= reader.width() - 1 && place->center.y() <= reader.height() - 1;
  if (!sample.inside) return;
  const float half_px = static_cast<float>(std::min(kSampledShare * place->side, kMostSampledPx));
  sample.light =
      reader.Rgb(static_cast<float>(place->center.x()), static_cast<float>(place->center.y()), half_px).cwiseMax(0);
  sample.blue_share = sample.light[2] / std::max(sample.light.sum(), 1e-6f);
}

/// Neighbours leave the cells at the corners of a board out, and place others roughly.
void BoardFinder::ResampleByHomography(const Lattice::Window& window, const LightReader& reader) {
  if (shared_) return;
  shared_ = true;
  for (int y = window.y - 1; y < window.y + window.rows; ++y)
    for (int x = window.x - 1; x < window.x + window.cols; ++x)
      SampleCell(x, y, reader,
                 cells_[static_cast<std::size_t>((y - cell_window_.y) * cell_window_.cols + x - cell_window_.x)]);
  shared_ = false;
}

/// Whether the light cells of the border that should be yellow return less blue than the others. Whatever the white
/// is, so no colours need be computed: refuses nearly every window of a wall of tiles at once.
bool BoardFinder::MayBeBorder(const BorderPattern& pattern, const Lattice::Window& window, int turn,
                              const LightReader& reader) {
  // Most windows fail by the means.
  std::array<float, 2> n{}, sum{};  // by saturation
  for (const auto& [cell, saturated] : pattern.light_cells[static_cast<std::size_t>(turn)]) {
    const CellSample& sample = CellAt(window.x - 1 + cell.col, window.y - 1 + cell.row, reader);
    n[saturated] += sample.inside ? 1.0f : 0.0f;
    sum[saturated] += sample.blue_share;
  }
  if (n[0] < 2 || n[1] < 2 || sum[0] * n[1] - sum[1] * n[0] < kLeastBlueDifference * n[0] * n[1]) return false;
  std::array<std::vector<float>, 2>& shares = blue_shares_;
  for (std::vector<float>& group : shares) group.clear();
  for (const auto& [cell, saturated] : pattern.light_cells[static_cast<std::size_t>(turn)]) {
    const CellSample& sample = CellAt(window.x - 1 + cell.col, window.y - 1 + cell.row, reader);
    if (sample.inside) shares[saturated].push_back(sample.blue_share);
  }
  // Medians: something may lie over a side.
  float variance = 0;
  std::array<float, 2> middle{};
  for (std::size_t group = 0; group < 2; ++group) {
    if (shares[group].size() < 2) return false;
    middle[group] = Median(shares[group]);
    for (float& share : shares[group]) share = std::abs(share - middle[group]);
    const float deviation = 1.4826f * Median(shares[group]);
    variance += deviation * deviation / static_cast<float>(shares[group].size());
  }
  return middle[0] - middle[1] > kLeastBlueLead * std::sqrt(variance);
}

void BoardFinder::MarkVisible(const Lattice::Window& window, const LightReader& reader) {
  const int cols = window.cols + 1, rows = window.rows + 1;
  samples_.resize(static_cast<std::size_t>(cols * rows));
  lead_.resize(samples_.size());
  visible_.resize(samples_.size());
  value_.resize(samples_.size());
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col) {
      const std::size_t i = static_cast<std::size_t>(row * cols + col);
      samples_[i] = CellAt(window.x - 1 + col, window.y - 1 + row, reader);
      value_[i] = std::sqrt(samples_[i].light[0] + samples_[i].light[1]);
    }
  // How much lighter each cell is than its neighbours, in the measure that knows blue from black least. The sign is
  // that of the cell's class where the board is in view.
  sorted_.clear();
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col) {
      const std::size_t i = static_cast<std::size_t>(row * cols + col);
      float sum = 0, count = 0;
      const auto add = [&](bool exists, std::size_t neighbour) {
        if (!exists || !samples_[neighbour].inside) return;
        sum += value_[neighbour];
        count += 1;
      };
      add(row > 0, i - static_cast<std::size_t>(cols));
      add(row + 1 < rows, i + static_cast<std::size_t>(cols));
      add(col > 0, i - 1);
      add(col + 1 < cols, i + 1);
      lead_[i] = count > 0 ? value_[i] - sum / count : 0;
      sorted_.push_back(std::abs(lead_[i]));
    }
  const auto upper = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() * 2 / 3);
  std::nth_element(sorted_.begin(), upper, sorted_.end());
  const float least = 0.3f * *upper;
  // The lattice's cell (i, j) is light where i + j is even.
  showing_ = 0;
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col) {
      const std::size_t i = static_cast<std::size_t>(row * cols + col);
      const bool dark = (window.x - 1 + col + window.y - 1 + row) % 2 != 0;
      visible_[i] = samples_[i].inside && (dark ? -lead_[i] : lead_[i]) > least;
      showing_ += visible_[i];
    }
}

bool BoardFinder::JudgeBorder(Placement& placement, AnchoredBoard* board) {
  const BorderPattern& pattern = patterns_[static_cast<std::size_t>(placement.pattern)];
  const MarkerSize size = pattern.size;
  const int cols = placement.corners.cols + 1;
  const auto index = [&](int row, int col) {
    const Cell cell = InFootprint(size, row, col, placement.turn);
    return static_cast<std::size_t>(cell.row * cols + cell.col);
  };
  const auto covered = [&](int row, int col) {
    const Cell cell = InFootprint(size, row, col, placement.turn);
    return placement.covered.Holds(cell.row, cell.col, placement.corners.rows + 1, cols);
  };
  const auto visible = [&](int row, int col) {
    const std::size_t i = index(row, col);
    return visible_[i] && !covered(row, col);
  };
  if (board) {
    board->light.resize(static_cast<std::size_t>(size.rows * size.cols));
    board->saturated.assign(board->light.size(), 0);
    for (int row = 0; row < size.rows; ++row)
      for (int col = 0; col < size.cols; ++col)
        board->light[static_cast<std::size_t>(row * size.cols + col)] = samples_[index(row, col)].light;
    board->covered.resize(board->light.size());
    for (int row = 0; row < size.rows; ++row)
      for (int col = 0; col < size.cols; ++col)
        board->covered[static_cast<std::size_t>(row * size.cols + col)] = !visible(row, col);
    HideBetween(size, board->covered);
  }
  const int seen = ShowingBesides(placement), lines = placement.covered.lines;
  // White, by the border cells that are white if this turn is right.
  Eigen::Vector3f white = Eigen::Vector3f::Zero();
  int whites = 0, border_seen = 0;
  for (std::size_t k = 0; k < pattern.cells.size(); ++k) {
    const Cell& cell = pattern.cells[k];
    if (!visible(cell.row, cell.col)) continue;
    ++border_seen;
    if (IsDark(cell.row, cell.col) || pattern.saturated[k]) continue;
    white += samples_[index(cell.row, cell.col)].light;
    ++whites;
  }
  if (whites < 2) return Refuse(placement, Refusal::kBorderUnseen, whites, 2);
  const int least = std::min(kLeastBorder, BorderLength(size));
  if (border_seen < least) return Refuse(placement, Refusal::kBorderUnseen, border_seen, least);
  white /= static_cast<float>(whites);
  if (!(white.minCoeff() > 1e-5f)) return Refuse(placement, Refusal::kBorderUnseen, 0, 2);

  const auto saturation = [&](int row, int col) {
    return ColourOf(samples_[index(row, col)].light, white, IsDark(row, col), space_).saturation;
  };
  // Group means of eq. 4, apart for light and dark cells, whose inks differ in strength.
  std::array<std::array<GaussianSum, 2>, 2> groups;  // [dark][saturated]
  values_.clear();
  for (std::size_t k = 0; k < pattern.cells.size(); ++k) {
    const Cell& cell = pattern.cells[k];
    if (!visible(cell.row, cell.col)) continue;
    const float value = saturation(cell.row, cell.col);
    values_.emplace_back(k, value);
    groups[IsDark(cell.row, cell.col)][pattern.saturated[k]].Add(value);
  }
  std::array<double, 2> threshold{};
  for (std::size_t dark = 0; dark < 2; ++dark) {
    const Gaussian plain = groups[dark][0].Get(), inked = groups[dark][1].Get();
    if (plain.count < 2 || inked.count < 2)
      return Refuse(placement, Refusal::kBorderUnseen, std::min(plain.count, inked.count), 2);
    const double error = std::sqrt((plain.deviation * plain.deviation + 0.25) / plain.count +
                                   (inked.deviation * inked.deviation + 0.25) / inked.count);
    const double least_apart = (lines ? 2 : 1) * kLeastSeparation;
    if (inked.mean - plain.mean < least_apart * error)
      return Refuse(placement, Refusal::kInksAlike, (inked.mean - plain.mean) / error, least_apart);
    threshold[dark] = (plain.mean + inked.mean) / 2;
  }
  int matches = 0;
  for (const auto& [k, value] : values_) {
    const Cell& cell = pattern.cells[k];
    matches += (value > threshold[IsDark(cell.row, cell.col)]) == (pattern.saturated[k] != 0);
  }
  placement.border_seen = border_seen;
  placement.border_matches = matches;
  placement.score = 2 * matches - placement.border_seen + 0.25 * seen;
  const double least_matches = (lines ? 1 : kLeastMatches) * placement.border_seen;
  if (matches < least_matches) return Refuse(placement, Refusal::kBorderDiffers, matches, least_matches);
  if (board) {
    for (int row = 0; row < size.rows; ++row)
      for (int col = 0; col < size.cols; ++col) {
        const std::size_t cell = static_cast<std::size_t>(row * size.cols + col);
        board->saturated[cell] = saturation(row, col) > threshold[IsDark(row, col)];
      }
  }
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
    if (!(ShowsEnough(placement) && JudgeBorder(placement, nullptr)) && !JudgeCovered(placement)) continue;
    // The border's period is four cells: turned by half a turn and two cells off, a board with two lines hidden looks
    // the same, but one of its sides lies inside the board in truth.
    if (placement.border_seen < kAllButTwoLines * BorderLength(size) && HasCornersOnItsSides(window)) {
      Refuse(placement, Refusal::kGoesOn, 0, 0);
      continue;
    }
    placements_.push_back(placement);
  }
}

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
      if (ShowsEnough(placement) && JudgeBorder(placement, nullptr)) return true;
  return false;
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
  for (const auto& [count, at] : windows_)
    if (!one_board || count > kLeastOfMost * most) TryWindow(pattern, at, turned, reader);
}

bool BoardFinder::Build(const Placement& placement, const LightReader& reader, const Lens& lens, AnchoredBoard& board) {
  const BorderPattern& pattern = patterns_[static_cast<std::size_t>(placement.pattern)];
  const Lattice::Window& window = placement.corners;
  board.size = pattern.size;
  if (!FitWindow(window, &pairs_)) return Refuse(placement, Refusal::kNotPlane, 0, 0);
  ResampleByHomography(window, reader);
  MarkVisible(window, reader);
  Placement judged = placement;
  if (!JudgeBorder(judged, &board)) return false;
  board.border_seen = judged.border_seen;
  board.border_matches = judged.border_matches;
  // Board coordinates: from the footprint's centre, turned.
  const Eigen::Vector2d center(window.x + 0.5 * (window.cols - 1), window.y + 0.5 * (window.rows - 1));
  constexpr std::array<int, 4> kCos{1, 0, -1, 0}, kSin{0, 1, 0, -1};
  const int cos = kCos[static_cast<std::size_t>(placement.turn)], sin = kSin[static_cast<std::size_t>(placement.turn)];
  const Eigen::Matrix2d board_from_lattice = (Eigen::Matrix2d() << cos, sin, -sin, cos).finished();
  board.box = {};
  for (PointPair& pair : pairs_) {
    board.box.Add(static_cast<float>(pair.to.x()), static_cast<float>(pair.to.y()));
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
  for (int y = window.y; y < window.y + window.rows; ++y)
    for (int x = window.x; x < window.x + window.cols; ++x)
      if (const Lattice::Point* point = lattice_.At(x, y)) {
        sorted_.push_back(point->scale);
        claimed_[static_cast<std::size_t>(point->corner)] = 1;
      }
  board.scale = Median(sorted_);
  return true;
}

void BoardFinder::TakeBest(const LightReader& reader, const Lens& lens, std::vector<AnchoredBoard>& boards) {
  std::sort(placements_.begin(), placements_.end(),
            [](const Placement& a, const Placement& b) { return a.score > b.score; });
  // Footprints overlap if they share a cell.
  const auto overlap = [](const Lattice::Window& a, const Lattice::Window& b) {
    return a.x < b.x + b.cols + 1 && b.x < a.x + a.cols + 1 && a.y < b.y + b.rows + 1 && b.y < a.y + a.rows + 1;
  };
  taken_.clear();
  for (std::size_t i = 0; i < placements_.size(); ++i) {
    const auto overlaps_taken = [&](std::size_t k) {
      return std::any_of(taken_.begin(), taken_.end(),
                         [&](std::size_t t) { return overlap(placements_[t].corners, placements_[k].corners); });
    };
    if (overlaps_taken(i)) continue;
    bool rivalled = false;
    for (std::size_t k = i + 1; k < placements_.size() && !rivalled; ++k)
      rivalled = placements_[k].score > placements_[i].score - kLeastLead &&
                 overlap(placements_[i].corners, placements_[k].corners) && !overlaps_taken(k);
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

bool BoardFinder::Find(const Grid& grid, std::span<const LatticeCorner> members, const std::vector<Corner>& corners,
                       const CornerSearch& search, const LightReader& reader, const Lens& lens,
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
  shared_ = cols <= most_corners_ + 2 && rows <= most_corners_ + 2 && FitWindow(all, nullptr);
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
