// Whether a placement's border shows the saturations it should.
#include <algorithm>
#include <cmath>

#include "core/median.h"
#include "detect/boards/anchor.h"
#include "detect/common/colours.h"
#include "detect/common/cover.h"

namespace chequer {
namespace {

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

}  // namespace

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
  std::array<std::vector<float>, 2>& shares = grid_->blue_shares;
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
    middle[group] = MedianInPlace(shares[group]);
    for (float& share : shares[group]) share = std::abs(share - middle[group]);
    const float deviation = 1.4826f * MedianInPlace(shares[group]);
    variance += deviation * deviation / static_cast<float>(shares[group].size());
  }
  return middle[0] - middle[1] > kLeastBlueLead * std::sqrt(variance);
}

bool BoardFinder::IsVisible(const Placement& placement, std::size_t cell) const {
  if (!grid_->visible[cell] || placement.covered.lines == 0) return grid_->visible[cell];
  const int cols = placement.corners.cols + 1, at = static_cast<int>(cell);
  return !placement.covered.Holds(at / cols, at % cols, placement.corners.rows + 1, cols);
}

float BoardFinder::SaturationOf(const Placement& placement, std::size_t cell, bool dark) const {
  return ColourOf(grid_->samples[cell].light, placement.white, dark, sought_.space).saturation;
}

void BoardFinder::DescribeCells(const Placement& placement, AnchoredBoard& board) const {
  const BorderPattern& pattern = sought_.patterns[static_cast<std::size_t>(placement.pattern)];
  const MarkerSize size = pattern.size;
  const std::vector<std::size_t>& in_footprint = pattern.in_footprint[static_cast<std::size_t>(placement.turn)];
  board.light.Assign(in_footprint.size(), Eigen::Vector3f::Zero());
  board.saturated.Assign(in_footprint.size(), 0);
  board.covered.Assign(in_footprint.size(), 0);
  ForCells(size, [&](std::size_t cell, int row, int col) {
    const std::size_t sample = in_footprint[cell];
    const bool dark = IsDark(row, col);
    board.light[cell] = grid_->samples[sample].light;
    board.saturated[cell] = SaturationOf(placement, sample, dark) > placement.threshold[dark];
    board.covered[cell] = !IsVisible(placement, sample);
  });
  HideBetween(size, board.covered);
}

bool BoardFinder::GatherBorder(Placement& placement) {
  const BorderPattern& pattern = sought_.patterns[static_cast<std::size_t>(placement.pattern)];
  const std::vector<std::size_t>& in_footprint = pattern.in_footprint[static_cast<std::size_t>(placement.turn)];
  Eigen::Vector3f white = Eigen::Vector3f::Zero();
  int whites = 0;
  grid_->border.clear();
  for (std::size_t k = 0; k < pattern.cells.size(); ++k) {
    const Cell& cell = pattern.cells[k];
    const std::size_t sample = in_footprint[static_cast<std::size_t>(cell.row * pattern.size.cols + cell.col)];
    if (!IsVisible(placement, sample)) continue;
    const bool dark = IsDark(cell.row, cell.col), saturated = pattern.saturated[k] != 0;
    grid_->border.push_back({sample, dark, saturated, 0});
    if (dark || saturated) continue;
    white += grid_->samples[sample].light;
    ++whites;
  }
  if (whites < 2) return Refuse(placement, Refusal::kBorderUnseen, whites, 2);
  const int border_seen = static_cast<int>(grid_->border.size());
  grid_->work.Add(WorkStep::kBorderCell, grid_->border.size());
  const int least = std::min(kLeastBorder, BorderLength(pattern.size));
  if (border_seen < least) return Refuse(placement, Refusal::kBorderUnseen, border_seen, least);
  placement.white = white / static_cast<float>(whites);
  return placement.white.minCoeff() > 1e-5f || Refuse(placement, Refusal::kBorderUnseen, 0, 2);
}

bool BoardFinder::MeasureInks(Placement& placement) {
  std::array<std::array<GaussianSum, 2>, 2> groups;  // [dark][saturated]
  for (BorderCell& cell : grid_->border) {
    cell.saturation = SaturationOf(placement, cell.sample, cell.dark);
    groups[cell.dark][cell.saturated].Add(cell.saturation);
  }
  double apart = 0;
  const double strict = placement.covered.lines ? 2 : 1;
  for (std::size_t dark = 0; dark < 2; ++dark) {
    const Gaussian plain = groups[dark][0].Get(), inked = groups[dark][1].Get();
    if (plain.count < 2 || inked.count < 2)
      return Refuse(placement, Refusal::kBorderUnseen, std::min(plain.count, inked.count), 2);
    const double error = std::sqrt((plain.deviation * plain.deviation + 0.25) / plain.count +
                                   (inked.deviation * inked.deviation + 0.25) / inked.count);
    const double separation = (inked.mean - plain.mean) / error;
    placement.inks_alike = separation > 0;
    if (separation < strict * kLeastOfEach)
      return Refuse(placement, Refusal::kInksAlike, separation, strict * kLeastOfEach);
    apart += separation;
    placement.threshold[dark] = (plain.mean + inked.mean) / 2;
  }
  if (apart < strict * kLeastSeparation)
    return Refuse(placement, Refusal::kInksAlike, apart, strict * kLeastSeparation);
  placement.inks_alike = false;
  return true;
}

bool BoardFinder::JudgeBorder(Placement& placement) {
  grid_->work.Add(WorkStep::kJudgement);
  const int seen = ShowingBesides(placement);
  if (!GatherBorder(placement) || !MeasureInks(placement)) return false;
  int matches = 0;
  for (const BorderCell& cell : grid_->border)
    matches += (cell.saturation > placement.threshold[cell.dark]) == cell.saturated;
  placement.border_seen = static_cast<int>(grid_->border.size());
  placement.border_matches = matches;
  placement.score = 2 * matches - placement.border_seen + 0.25 * seen;
  const double least_matches = (placement.covered.lines ? 1 : kLeastMatches) * placement.border_seen;
  return matches >= least_matches || Refuse(placement, Refusal::kBorderDiffers, matches, least_matches);
}

bool BoardFinder::JudgeUnmixed(Placement& placement, const LightReader& reader) {
  if (!placement.inks_alike || !grid_->small) return false;
  UnmixCells(reader);
  MarkVisible(placement.corners, reader);
  return ShowsEnough(placement) && JudgeBorder(placement);
}

}  // namespace chequer
