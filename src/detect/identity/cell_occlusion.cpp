#include "detect/identity/cell_occlusion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/median.h"

namespace chequer {
namespace {

/// A cell is hidden if its hue is farther from its ink's, or of the kernel from both of its class, than the first share
/// of the inks' distance, and than so many times the median distance of the border's cells from theirs (guesses).
/// It looks mixed from the second share on (a guess).
constexpr float kOffColour = 0.45f, kTinted = 0.15f, kOffUsual = 6;
/// A light cell looks mixed if it has a smaller share of the light of the border's median cell of its ink, a dark one
/// if it has more than that of its ink by a larger share of white's. So many tell what an ink has at least (guesses).
constexpr float kLeastOfInk = 0.8f, kMostOverInk = 0.2f;
constexpr std::size_t kFewestOfInk = 3;
/// Ink that reflects less than nothing, by more than this share of white's light, was not in the light that the fit
/// took it to be in (a guess).
constexpr float kMostBelowBlack = 0.15f;
/// A blur of so many cells hides how the light differs within a cell that is covered in part: its colour has to tell.
/// In sharper images the light tells better. (Measured: if colours counted there too, 9 of 33 sharp boards with a wire
/// would be read.)
constexpr double kBlurred = 0.14;
/// One line of cells is hidden if no more cells than that line and so many others have no used corner (a guess).
constexpr int kFewUnseen = 2;
/// Least difference of a cell to its neighbours, as a share of the contrast of the board (a guess).
constexpr double kLeastContrastOfCell = 0.3;
/// The light within a cell differs by less than the first share of the lightest cell's. A light cell has at least the
/// second share of the darkest other light cell's. Print and shading change less (guesses).
constexpr float kOneLight = 0.15f, kLeastOfDarkest = 0.7f;

float LightnessOf(const Eigen::Vector3f& light) { return light[0] + light[1]; }

}  // namespace

void CellOcclusion::Find(const FittedBoard& board, MarkerSize size, std::span<const Eigen::Vector3f> light) {
  Visibility& visibility = found_.Start().visibility;
  visibility = board.visibility;
  // A motion that no term has is a part of the blur.
  const BlurShape term{board.image.motion_px, 0};
  found_->blurred = term.BlurPx(board.image.blur_px) > kBlurred * board.geometry.CellSide();
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

float CellOcclusion::OffInks(const ShownCells& cells, std::size_t cell, int row, int col) const {
  const Eigen::Vector3f& hue = found_->hues[cell];
  const std::array<Eigen::Vector3f, 2>& inks = found_->classes[IsDark(row, col)].inks;
  const bool border = IsBorder(cells.size, row, col);
  // The more light falls on an overexposed cell, the more of its channels are full scale: it goes on to white.
  if (cells.lights.overexposed[cell] && !(border && !cells.border[cell])) {
    const Eigen::Vector3f to_white = inks[0] - inks[1], from_ink = hue - inks[1];
    const float way = std::max(to_white.squaredNorm(), 1e-9f);
    return (from_ink - std::clamp(from_ink.dot(to_white) / way, 0.0f, 1.0f) * to_white).norm();
  }
  if (border) return (hue - inks[cells.border[cell]]).norm();
  return std::min((hue - inks[0]).norm(), (hue - inks[1]).norm());
}

void CellOcclusion::MeasureLightness(const ShownCells& cells, const Eigen::Vector3f& white) {
  std::vector<float>& values = found_->values;
  const float of_white = LightnessOf(white);
  // What is overexposed does not tell how light white is.
  const bool white_told = std::ranges::find(cells.lights.overexposed, 1) == cells.lights.overexposed.end();
  found_->below_black = false;
  for (std::size_t saturated = 0; saturated < 2; ++saturated) {
    const auto median_of = [&](OfClass& of_class) -> std::optional<float> {
      values.clear();
      for (const std::size_t cell : of_class.told_by[saturated])
        values.push_back(LightnessOf(cells.lights.light[cell]));
      if (values.size() < kFewestOfInk) return std::nullopt;
      return MedianInPlace(values);
    };
    const std::optional<float> light = median_of(found_->classes[0]), dark = median_of(found_->classes[1]);
    found_->classes[0].lightness[saturated] = {.least = light ? kLeastOfInk * *light : 0};
    found_->classes[1].lightness[saturated] = {};
    if (dark && white_told) found_->classes[1].lightness[saturated].most = *dark + kMostOverInk * of_white;
    found_->below_black = found_->below_black || (dark && *dark < -kMostBelowBlack * of_white);
  }
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
  for (std::size_t saturated = 0; saturated < 2; ++saturated)
    for (const std::size_t cell : of_class.told_by[saturated])
      values.push_back((found_->hues[cell] - of_class.inks[saturated]).norm());
  const float apart = (of_class.inks[1] - of_class.inks[0]).norm(), usual = MedianInPlace(values);
  of_class.most_off = std::max(kOffColour * apart, kOffUsual * usual);
  of_class.least_tint = std::max(kTinted * apart, kOffUsual * usual);
  of_class.told = true;
}

bool CellOcclusion::LooksMixed(const ShownCells& cells, std::size_t cell, int row, int col, float off_inks) const {
  const OfClass& of_class = found_->classes[IsDark(row, col)];
  const auto& [plain, inked] = of_class.lightness;
  const float light = LightnessOf(cells.lights.light[cell]);
  const bool border = IsBorder(cells.size, row, col);
  LightRange range{std::min(plain.least, inked.least), std::max(plain.most, inked.most)};
  if (border) range = cells.border[cell] ? inked : plain;
  if (!found_->blurred) return border && light < range.least;
  return light < range.least || light > range.most ||
         (off_inks > of_class.least_tint && !cells.lights.overexposed[cell]);
}

bool CellOcclusion::AddOffColour(const ShownCells& cells, const Eigen::Vector3f& white) {
  MeasureHues(cells, white);
  for (OfClass& of_class : found_->classes) MeasureInkHues(of_class);
  MeasureLightness(cells, white);
  found_->mixed.assign(found_->wrong.size(), 0);
  ForCells(cells.size, [&](std::size_t cell, int row, int col) {
    const OfClass& of_class = found_->classes[IsDark(row, col)];
    if (!of_class.told || found_->wrong[cell]) return;
    const float off = OffInks(cells, cell, row, col);
    if (!(off <= of_class.most_off)) found_->wrong[cell] = 1;
    found_->mixed[cell] = LooksMixed(cells, cell, row, col, off);
  });
  return HideWrong(cells.size, Hidden::kOffColour);
}

template <class Uneven>
int CellOcclusion::ToldOfLine(MarkerSize size, int row, int col, const Uneven& uneven) const {
  const auto index = [&](Cell at) { return static_cast<std::size_t>(at.row * size.cols + at.col); };
  const auto shows = [&](Cell at) { return found_->visibility.Shows(index(at)) && !found_->mixed[index(at)]; };
  const auto of_line = [&](bool along_row) {
    const int last = (along_row ? size.cols : size.rows) - 1;
    const auto at = [&](int i, int across) { return along_row ? Cell{row + across, i} : Cell{i, col + across}; };
    // A hand hides those beside it, too.
    const auto covered = [&](int i) { return !shows(at(i, 0)) && shows(at(i, -1)) && shows(at(i, 1)); };
    const bool at_first = covered(0), at_last = covered(last);
    if (at_first == at_last) return 2 * int{at_first};
    bool more = uneven(index(at(at_first ? last : 0, 0)));
    for (int i = 1; i < last && found_->blurred; ++i) more = more || covered(i);
    return 1 + int{more};
  };
  return std::max(of_line(true), of_line(false));
}

void CellOcclusion::FindReached(const BoardInImage& in, std::span<const Eigen::Vector3f> light) {
  const Visibility& visibility = found_->visibility;
  found_->reached.assign(light.size(), Reach::kNone);
  const bool none_mixed = std::ranges::find(found_->mixed, 1) == found_->mixed.end();
  const bool hidden = !visibility.ShowsAll() || !visibility.ShowsAllCorners();
  if (none_mixed && !hidden) return;
  std::vector<std::uint8_t>& clear = found_->seen;
  clear.assign(light.size(), 0);
  Eigen::Vector3f most = Eigen::Vector3f::Zero();
  float darkest = std::numeric_limits<float>::max();  // of light cells
  ForCells(in.size, [&](std::size_t cell, int row, int col) {
    clear[cell] = visibility.Shows(cell) && visibility.ShowsAround(row, col);
    if (!clear[cell]) return;
    most = most.cwiseMax(light[cell]);
    if (!IsDark(row, col)) darkest = std::min(darkest, LightnessOf(light[cell]));
  });
  const auto uneven = [&](std::size_t cell) {
    return (LightDiffers(in, cell).array() > kOneLight * most.array()).any();
  };
  ForCells(in.size, [&](std::size_t cell, int row, int col) {
    if (!visibility.Shows(cell)) return;
    const int told = IsBorder(in.size, row, col) ? 0 : ToldOfLine(in.size, row, col, uneven);
    const bool too_dark = !IsDark(row, col) && LightnessOf(light[cell]) < kLeastOfDarkest * darkest;
    if (told == 2 || (told == 1 && uneven(cell)) || (hidden && found_->mixed[cell] != 0))
      found_->reached[cell] = Reach::kOver;
    else if (!clear[cell] && (too_dark || uneven(cell)))
      found_->reached[cell] = Reach::kBeside;
  });
}

}  // namespace chequer
