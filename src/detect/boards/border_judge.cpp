// Whether a placement shows enough, and its border the saturations it should.
#include <algorithm>
#include <cmath>

#include "core/median.h"
#include "detect/boards/boards.h"
#include "detect/boards/placement.h"
#include "detect/common/board_geometry.h"
#include "detect/common/colours.h"
#include "detect/common/neighbours.h"

namespace chequer {
namespace {

/// Least share of cells that are clearly lighter or darker than their neighbours (a guess).
constexpr double kLeastVisible = 0.5;
/// The same share for a partly occluded board, among its other cells (a guess).
constexpr double kLeastVisibleBesides = 0.8;
/// Fewest border cells that are judged, and the least share of them that matches (guesses; by chance, one placement in
/// 400 matches as well).
constexpr int kLeastBorder = 9;
constexpr double kLeastMatches = 0.85;
/// How much less blue yellow cells return than white ones: as a share of their light, and in standard deviations of the
/// difference (guesses: what passes is judged by its whole border).
constexpr float kLeastBlueDifference = 0.004f, kLeastBlueLead = 2;
/// Distance of the group means over its standard error: the sum over light and dark cells, and of each. Dark cells that
/// are 3 px high mix with their neighbours and lose half of theirs (guesses).
constexpr double kLeastSeparation = 8, kLeastOfEach = 2.5;

float SaturationOf(const Placement& placement, const CellSample& sample, bool dark, ColorSpace space) {
  return ColourOf(sample.light, placement.white, dark, space).saturation;
}

int CellsBesides(const Placement& placement) {
  return placement.rows() * placement.cols() -
         placement.covered.lines * (placement.covered.side < 2 ? placement.cols() : placement.rows());
}

int ShowingBesides(const Placement& placement, const Footprint& footprint) {
  const Cover& covered = placement.covered;
  const int rows = placement.rows(), cols = placement.cols();
  const bool across = covered.side < 2, at_end = covered.side % 2 == 1;
  int occluded = 0;
  for (int line = 0; line < covered.lines; ++line) {
    const int at = at_end ? (across ? rows : cols) - 1 - line : line;
    for (int i = 0; i < (across ? cols : rows); ++i)
      occluded += footprint.visible[static_cast<std::size_t>(across ? at * cols + i : i * cols + at)];
  }
  return footprint.showing - occluded;
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
  for (int turn = 0; turn < 4; ++turn) {
    const int footprint_cols = turn % 2 == 0 ? size.cols : size.rows;
    for (int row = 0; row < size.rows; ++row)
      for (int col = 0; col < size.cols; ++col) {
        const Cell cell = InFootprint(size, row, col, turn);
        in_footprint[static_cast<std::size_t>(turn)].push_back(
            static_cast<std::size_t>(cell.row * footprint_cols + cell.col));
      }
    for (std::size_t k = 0; k < cells.size(); ++k)
      if (!IsDark(cells[k].row, cells[k].col))
        light_cells[static_cast<std::size_t>(turn)].emplace_back(InFootprint(size, cells[k].row, cells[k].col, turn),
                                                                 saturated[k]);
  }
}

Verdict ShowsEnough(const Placement& placement, const Footprint& footprint) {
  // What is left of a covered board has to be beyond doubt.
  const double least = (placement.covered.lines ? kLeastVisibleBesides : kLeastVisible) * CellsBesides(placement);
  const int showing = ShowingBesides(placement, footprint);
  if (showing >= least) return {};
  return {Refusal::kCellsDoNotShow, static_cast<double>(showing), least};
}

int NotShowing(const Placement& placement, const Footprint& footprint) {
  return CellsBesides(placement) - ShowingBesides(placement, footprint);
}

bool BorderJudge::MayBeBorder(const Placement& placement, LatticeCells& cells) {
  // Most windows fail by the means.
  std::array<float, 2> n{}, sum{};  // by saturation
  const auto& light_cells = placement.pattern->light_cells[static_cast<std::size_t>(placement.turn)];
  const auto at = [&](const Cell& cell) -> const CellSample& {
    return cells.At(placement.corners.x - 1 + cell.col, placement.corners.y - 1 + cell.row);
  };
  for (const auto& [cell, saturated] : light_cells) {
    const CellSample& sample = at(cell);
    n[saturated] += sample.inside ? 1.0f : 0.0f;
    sum[saturated] += sample.blue_share;
  }
  if (n[0] < 2 || n[1] < 2 || sum[0] * n[1] - sum[1] * n[0] < kLeastBlueDifference * n[0] * n[1]) return false;
  for (std::vector<float>& group : blue_shares_) group.clear();
  for (const auto& [cell, saturated] : light_cells) {
    const CellSample& sample = at(cell);
    if (sample.inside) blue_shares_[saturated].push_back(sample.blue_share);
  }
  // Medians: something may lie over a side.
  float variance = 0;
  std::array<float, 2> middle{};
  for (std::size_t group = 0; group < 2; ++group) {
    if (blue_shares_[group].size() < 2) return false;
    middle[group] = MedianInPlace(blue_shares_[group]);
    for (float& share : blue_shares_[group]) share = std::abs(share - middle[group]);
    const float deviation = 1.4826f * MedianInPlace(blue_shares_[group]);
    variance += deviation * deviation / static_cast<float>(blue_shares_[group].size());
  }
  return middle[0] - middle[1] > kLeastBlueLead * std::sqrt(variance);
}

void BorderJudge::Describe(const Placement& placement, const Footprint& footprint, AnchoredBoard& board) const {
  const BorderPattern& pattern = *placement.pattern;
  const MarkerSize size = pattern.size;
  const std::vector<std::size_t>& in_footprint = pattern.in_footprint[static_cast<std::size_t>(placement.turn)];
  board.light.Assign(in_footprint.size(), Eigen::Vector3f::Zero());
  board.saturated.Assign(in_footprint.size(), 0);
  board.visibility = Visibility(size);
  ForCells(size, [&](std::size_t cell, int row, int col) {
    const std::size_t sample = in_footprint[cell];
    const bool dark = IsDark(row, col);
    board.light[cell] = footprint.samples[sample].light;
    board.saturated[cell] =
        SaturationOf(placement, footprint.samples[sample], dark, space_) > placement.threshold[dark];
    if (!footprint.samples[sample].inside)
      board.visibility.Hide(cell, Hidden::kOutside);
    else if (!placement.Shows(footprint, sample))
      board.visibility.Hide(cell, footprint.visible[sample] ? Hidden::kCovered : Hidden::kFlat);
  });
  board.visibility.HideEnclosed();
}

Verdict BorderJudge::Gather(const Footprint& footprint, Placement& placement, WorkMeter& work) {
  const BorderPattern& pattern = *placement.pattern;
  const std::vector<std::size_t>& in_footprint = pattern.in_footprint[static_cast<std::size_t>(placement.turn)];
  Eigen::Vector3f white = Eigen::Vector3f::Zero();
  int whites = 0;
  border_.clear();
  for (std::size_t k = 0; k < pattern.cells.size(); ++k) {
    const Cell& cell = pattern.cells[k];
    const std::size_t sample = in_footprint[static_cast<std::size_t>(cell.row * pattern.size.cols + cell.col)];
    if (!placement.Shows(footprint, sample)) continue;
    const bool dark = IsDark(cell.row, cell.col), saturated = pattern.saturated[k] != 0;
    border_.push_back({sample, dark, saturated, 0});
    if (dark || saturated) continue;
    white += footprint.samples[sample].light;
    ++whites;
  }
  if (whites < 2) return {Refusal::kBorderUnseen, static_cast<double>(whites), 2};
  const double border_seen = static_cast<double>(border_.size());
  work.Add(WorkStep::kBorderCell, border_.size());
  const int least = std::min(kLeastBorder, BorderLength(pattern.size));
  if (border_seen < least) return {Refusal::kBorderUnseen, border_seen, static_cast<double>(least)};
  placement.white = white / static_cast<float>(whites);
  if (placement.white.minCoeff() > 1e-5f) return {};
  return {Refusal::kBorderUnseen, 0, 2};
}

Verdict BorderJudge::MeasureInks(const Footprint& footprint, Placement& placement) {
  std::array<std::array<GaussianSum, 2>, 2> groups;  // [dark][saturated]
  for (BorderCell& cell : border_) {
    cell.saturation = SaturationOf(placement, footprint.samples[cell.sample], cell.dark, space_);
    groups[cell.dark][cell.saturated].Add(cell.saturation);
  }
  double apart = 0;
  const double strict = placement.covered.lines ? 2 : 1;
  for (std::size_t dark = 0; dark < 2; ++dark) {
    const Gaussian plain = groups[dark][0].Get(), inked = groups[dark][1].Get();
    if (plain.count < 2 || inked.count < 2)
      return {Refusal::kBorderUnseen, static_cast<double>(std::min(plain.count, inked.count)), 2};
    const double error = std::sqrt((plain.deviation * plain.deviation + 0.25) / plain.count +
                                   (inked.deviation * inked.deviation + 0.25) / inked.count);
    const double separation = (inked.mean - plain.mean) / error;
    placement.inks_alike = separation > 0;
    if (separation < strict * kLeastOfEach) return {Refusal::kInksAlike, separation, strict * kLeastOfEach};
    apart += separation;
    placement.threshold[dark] = (plain.mean + inked.mean) / 2;
  }
  if (apart < strict * kLeastSeparation) return {Refusal::kInksAlike, apart, strict * kLeastSeparation};
  placement.inks_alike = false;
  return {};
}

Verdict BorderJudge::Judge(const Footprint& footprint, Placement& placement, WorkMeter& work) {
  work.Add(WorkStep::kJudgement);
  const int seen = ShowingBesides(placement, footprint);
  if (const Verdict unseen = Gather(footprint, placement, work); !unseen.passed()) return unseen;
  if (const Verdict alike = MeasureInks(footprint, placement); !alike.passed()) return alike;
  int matches = 0;
  for (const BorderCell& cell : border_)
    matches += (cell.saturation > placement.threshold[cell.dark]) == cell.saturated;
  placement.border_seen = static_cast<int>(border_.size());
  placement.border_matches = matches;
  placement.score = 2 * matches - placement.border_seen + 0.25 * seen;
  const double least_matches = (placement.covered.lines ? 1 : kLeastMatches) * placement.border_seen;
  if (matches >= least_matches) return {};
  return {Refusal::kBorderDiffers, static_cast<double>(matches), least_matches};
}

}  // namespace chequer
