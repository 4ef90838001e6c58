#include "detect/identity/cell_occlusion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/median.h"

namespace chequer {
namespace {

/// A cell is hidden if its hue is farther from both inks of its class than this share of the inks' distance, and than
/// so many times the median distance of the border's cells from theirs (guesses).
constexpr float kOffColour = 0.45f, kOffUsual = 6;
/// One line of cells is hidden if no more cells than that line and so many others have no used corner (a guess).
constexpr int kFewUnseen = 2;
/// Least difference of a cell to its neighbours, as a share of the contrast of the board (a guess).
constexpr double kLeastContrastOfCell = 0.3;
/// The light within a cell differs by less than the first share of the lightest cell's. A light cell has at least the
/// second share of the darkest other light cell's. Print and shading change less (guesses).
constexpr float kOneLight = 0.15f, kLeastOfDarkest = 0.7f;

}  // namespace

void CellOcclusion::Find(const FittedBoard& board, MarkerSize size, std::span<const Eigen::Vector3f> light) {
  Visibility& visibility = found_.Start().visibility;
  visibility = board.visibility;
  // Cells that no corner tells of may look like the board's: where they are but a line or so, only those that do not
  // are evidence of a cover. More of them lie under one.
  found_->wrong.assign(light.size(), 0);
  if (visibility.hidden_cells() > std::max(size.rows, size.cols) + kFewUnseen)
    std::ranges::transform(visibility.cells(), found_->wrong.begin(),
                           [](Hidden hidden) { return hidden != Hidden::kNot; });
  MarkFlat(size, light);
  HideWrong(size, Hidden::kFlat);
}

void CellOcclusion::MarkFlat(MarkerSize size, std::span<const Eigen::Vector3f> light) {
  const Visibility& visibility = found_->visibility;
  std::vector<float>& values = found_->values;
  values.clear();
  for (const Eigen::Vector3f& of_cell : light) values.push_back(std::sqrt(std::max(of_cell[0] + of_cell[1], 0.0f)));
  std::array<double, 2> sums{};
  std::array<int, 2> counts{};
  ForCells(size, [&](std::size_t cell, int row, int col) {
    if (!visibility.Shows(cell)) return;
    sums[IsDark(row, col)] += double{values[cell]};
    ++counts[IsDark(row, col)];
  });
  const double contrast = sums[0] / std::max(counts[0], 1) - sums[1] / std::max(counts[1], 1);
  found_->seen.resize(light.size());
  for (std::size_t cell = 0; cell < light.size(); ++cell) found_->seen[cell] = visibility.Shows(cell);
  const std::span<const float> leads = found_->neighbours.Of(size.rows, size.cols, values, found_->seen);
  ForCells(size, [&](std::size_t cell, int row, int col) {
    const float lead = IsDark(row, col) ? -leads[cell] : leads[cell];
    found_->wrong[cell] |= static_cast<std::uint8_t>(lead < kLeastContrastOfCell * contrast);
  });
}

bool CellOcclusion::HideWrong(MarkerSize size, Hidden why) {
  Visibility& visibility = found_->visibility;
  const int before = visibility.hidden_cells();
  const auto hide = [&](Hidden as) {
    for (std::size_t cell = 0; cell < found_->wrong.size(); ++cell)
      if (found_->wrong[cell]) visibility.Hide(cell, as);
  };
  hide(why);
  HideBetween(size, found_->wrong);
  hide(Hidden::kEnclosed);
  return visibility.hidden_cells() > before;
}

void CellOcclusion::MeasureHues(const ShownCells& cells, const Eigen::Vector3f& white) {
  for (OfClass& of_class : found_->classes)
    for (std::vector<std::size_t>& of_ink : of_class.told_by) of_ink.clear();
  found_->hues.resize(cells.lights.light.size());
  ForCells(cells.size, [&](std::size_t cell, int row, int col) {
    const bool dark = IsDark(row, col);
    if (IsBorder(cells.size, row, col) && cells.visibility.Shows(cell))
      found_->classes[dark].told_by[cells.border[cell]].push_back(cell);
    const Eigen::Vector3f of_white = cells.lights.light[cell].cwiseQuotient(white).cwiseMax(0);
    // Shading leaves the shares of the three channels alone; a veil of white light, what they differ by.
    if (dark)
      found_->hues[cell] = of_white.array() - of_white.minCoeff();
    else
      found_->hues[cell] = of_white / std::max(of_white.sum(), 1e-6f);
  });
}

float CellOcclusion::OffInks(const OfClass& of_class, std::size_t cell) const {
  const Eigen::Vector3f& hue = found_->hues[cell];
  return std::min((hue - of_class.inks[0]).norm(), (hue - of_class.inks[1]).norm());
}

void CellOcclusion::MeasureInkHues(OfClass& of_class) {
  of_class.told = false;
  std::vector<float>& values = found_->values;
  for (std::size_t saturated = 0; saturated < 2; ++saturated)
    for (int channel = 0; channel < 3; ++channel) {
      values.clear();
      for (const std::size_t cell : of_class.told_by[saturated]) values.push_back(found_->hues[cell][channel]);
      if (values.empty()) return;
      of_class.inks[saturated][channel] = MedianInPlace(values);
    }
  values.clear();
  for (const std::vector<std::size_t>& of_ink : of_class.told_by)
    for (const std::size_t cell : of_ink) values.push_back(OffInks(of_class, cell));
  const float apart = (of_class.inks[1] - of_class.inks[0]).norm();
  of_class.most_off = std::max(kOffColour * apart, kOffUsual * MedianInPlace(values));
  of_class.told = true;
}

bool CellOcclusion::AddOffColour(const ShownCells& cells, const Eigen::Vector3f& white) {
  MeasureHues(cells, white);
  for (OfClass& of_class : found_->classes) MeasureInkHues(of_class);
  ForCells(cells.size, [&](std::size_t cell, int row, int col) {
    const OfClass& of_class = found_->classes[IsDark(row, col)];
    if (!of_class.told || found_->wrong[cell]) return;
    if (!(OffInks(of_class, cell) <= of_class.most_off)) found_->wrong[cell] = 1;
  });
  return HideWrong(cells.size, Hidden::kOffColour);
}

void CellOcclusion::FindReached(const BoardInImage& in, std::span<const Eigen::Vector3f> light) {
  const Visibility& visibility = found_->visibility;
  found_->reached.assign(light.size(), 0);
  if (visibility.ShowsAll() && visibility.ShowsAllCorners()) return;
  std::vector<std::uint8_t>& clear = found_->seen;
  clear.assign(light.size(), 0);
  Eigen::Vector3f most = Eigen::Vector3f::Zero();
  float darkest = std::numeric_limits<float>::max();  // of light cells
  ForCells(in.size, [&](std::size_t cell, int row, int col) {
    clear[cell] = visibility.Shows(cell) && visibility.ShowsAround(row, col);
    if (!clear[cell]) return;
    most = most.cwiseMax(light[cell]);
    if (!IsDark(row, col)) darkest = std::min(darkest, light[cell][0] + light[cell][1]);
  });
  ForCells(in.size, [&](std::size_t cell, int row, int col) {
    if (clear[cell] || !visibility.Shows(cell)) return;
    const bool too_dark = !IsDark(row, col) && light[cell][0] + light[cell][1] < kLeastOfDarkest * darkest;
    found_->reached[cell] = too_dark || (LightDiffers(in, cell).array() > kOneLight * most.array()).any();
  });
}

}  // namespace chequer
