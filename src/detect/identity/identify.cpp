#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "detect/identity/cover_mix.h"
#include "detect/identity/marker_description.h"

namespace chequer {
namespace {

/// Largest log likelihood ratio of one cell. A cell may be badly printed, dirty or in a shadow, which its noise does
/// not show (a guess).
constexpr double kMostLikelihood = 12;
/// The same of a cell that may be covered in part. It is less than kLeastMargin, so that no such cell decides alone.
/// (Measured: of 7,800 boards, most of them with a strip or a corner covered, 3 ids were wrong instead of 8, and 6 %
/// fewer were decided.)
constexpr double kMostLikelihoodReached = 5;
/// Largest corner error of a partly occluded board. Corners of the occluder give 0.2 px, corners of the board 0.02 px
/// (measured).
constexpr double kMostOffCoveredPx = 0.08;
/// Least log likelihood ratio of the best word to the second best. Identifier says how often it errs, as measured.
constexpr double kLeastMargin = 6;
/// The same with a warning of poor illumination or white balance (a guess).
constexpr double kLeastMarginWarned = 9;
/// The same with such a warning where a cell is corrected or cells were solved for together. Of 2,100 ids of small
/// cells in JPEG of quality 60, the one wrong id had a corrected cell and a ratio of 10.7. Four wrong ids of 840 boards
/// with 4 px cells (quality 60, 4:2:0) came from cells solved together, where errors of chroma reach several cells.
constexpr double kLeastMarginDoubtful = 15;

/// The same, none at all, where so much is hidden that words differ in a single cell that shows, so that nothing
/// reveals one that is misread, and colours overlap by more: they do by .000 where all is well (of 4,000 boards with a
/// shadow's edge on them, 8 such were decided; the wrong one had .009).
constexpr double kMostOverlapUnchecked = 0.002;
/// Where corners as seen one by one lie farther from the fit than noise moves them, something lies between them, and
/// over cells: kLeastMarginDoubtful decides. Noise moves an edge by its blur (at least a pixel) over the ratio of
/// contrast to noise. The distances, root mean square, are about as much in the median, and so many times that for
/// fewer than 1 board in 200. (Measured: of 8,200 boards with something over them, 4 of 7 wrong ids had that, and
/// ratios of 12.3 at most.)
constexpr double kMostOffByNoise = 4.5;

std::vector<std::optional<Roster>> RostersOf(const DetectorOptions& options) {
  std::vector<std::optional<Roster>> rosters;
  for (const MarkerFamily& family : options.families)
    rosters.push_back(family.roster.empty() ? std::nullopt : std::optional<Roster>(family.roster));
  return rosters;
}

std::vector<std::vector<std::uint8_t>> BordersOf(const DetectorOptions& options) {
  std::vector<std::vector<std::uint8_t>> borders;
  for (const MarkerFamily& family : options.families) borders.push_back(CellSaturation(family.code.size(), 0));
  return borders;
}

bool CornersLieOff(const FittedBoard& board) {
  const double by_noise_px = std::max(board.image.blur_px, 1.0) / board.signal_to_noise;
  return board.reprojection_rms_px > kMostOffByNoise * by_noise_px;
}

/// A placement on a board of n rows and n or other columns: turns by 90°, then a shift.
struct OtherPlacement {
  int turns, down, right;

  Cell Of(MarkerSize size, int row, int col) const {
    int rows = size.rows, cols = size.cols;
    for (int turn = 0; turn < turns; ++turn) {
      const int turned = rows - 1 - row;
      row = col;
      col = turned;
      std::swap(rows, cols);
    }
    return {row + down, col + right};
  }
};

bool Agrees(MarkerSize size, const OtherPlacement& placement, std::span<const Hidden> hidden,
            std::span<const std::uint8_t> saturated, std::span<const std::uint8_t> border) {
  for (int row = 0; row < size.rows; ++row)
    for (int col = 0; col < size.cols; ++col) {
      const std::size_t from = static_cast<std::size_t>(row * size.cols + col);
      if (hidden[from] != Hidden::kNot) continue;
      const Cell to = placement.Of(size, row, col);
      if (to.row < 0 || to.col < 0 || to.row >= size.rows || to.col >= size.cols) return false;
      if (IsDark(row, col) != IsDark(to.row, to.col)) return false;
      const std::size_t at = static_cast<std::size_t>(to.row * size.cols + to.col);
      if (IsBorder(size, to.row, to.col) && saturated[from] != kInkUntold && saturated[from] != border[at])
        return false;
    }
  return true;
}

}  // namespace

bool AgreesElsewhere(MarkerSize size, std::span<const Hidden> hidden, std::span<const std::uint8_t> saturated,
                     std::span<const std::uint8_t> border) {
  const int most = std::max(size.rows, size.cols) - 1;
  for (int turns = 0; turns < 4; ++turns)
    for (int down = -most; down <= most; ++down)
      for (int right = -most; right <= most; ++right) {
        if (turns == 0 && down == 0 && right == 0) continue;
        if (Agrees(size, {turns, down, right}, hidden, saturated, border)) return true;
      }
  return false;
}

Identifier::Identifier(const DetectorOptions& options)
    : options_(options), rosters_(RostersOf(options)), borders_(BordersOf(options)), inks_(options.color_space) {}

bool Identifier::MeasureInks(const ShownCells& shown) {
  if (!inks_.Measure(shown)) return false;
  return !occlusion_.AddOffColour(shown, inks_.white()) || inks_.Measure(shown);
}

void Identifier::WeighKernel(const ShownCells& shown, Identity& identity) {
  std::optional<CoverMix> mix;
  if (!shown.visibility.ShowsAll()) mix.emplace(shown, inks_.white());
  cells_->log_likelihood.clear();
  ForCells(shown.size, [&](std::size_t cell, int row, int col) {
    if (IsBorder(shown.size, row, col)) return;
    const bool dark = IsDark(row, col);
    float& log_likelihood = cells_->log_likelihood.emplace_back(0.0f);
    const Reach reach = occlusion_.ReachOf(cell);
    // What lies over several cells mixes their colours alike, and they would be misread together. (Measured: of 14,000
    // boards, nearly all with something over them, 5 ids were wrong instead of 16, and 2 % fewer were decided. Of
    // 10,800 in blurred images with a strip, a band or a wire along cells, 1 of 1,659 ids was wrong instead of 25 of
    // 2,617.)
    if (!shown.visibility.Shows(cell) || !inks_.Of(dark).usable || reach == Reach::kOver) {
      ++identity.cells_hidden;
      return;
    }
    double lead = inks_.LeadOf(cell, dark, shown.lights.half_lit[cell]);
    if (mix) lead = mix->LeastLead(row, col, lead);
    const double spread = inks_.Of(dark).spread();
    const double most = reach == Reach::kBeside ? kMostLikelihoodReached : kMostLikelihood;
    log_likelihood = static_cast<float>(std::clamp(lead / (spread * spread), -most, most));
  });
}

void Identifier::Decode(MarkerSize size, Identity& identity) {
  for (std::size_t f = 0; f < options_.families.size(); ++f) {
    const MarkerFamily& family = options_.families[f];
    if (!(family.code.size() == size)) continue;
    const auto soft = family.code.DecodeSoft(cells_->log_likelihood, rosters_[f] ? &*rosters_[f] : nullptr);
    if (!soft) continue;
    if (soft->best.bits_corrected > family.code.guaranteed_radius()) {
      identity.cells_off = soft->best.bits_corrected;
      identity.cells_corrected = family.code.guaranteed_radius();
      continue;
    }
    if (soft->margin <= identity.margin) continue;
    identity.margin = soft->margin;
    identity.family = static_cast<int>(f);
    identity.decoded = soft->best;
  }
}

void Identifier::Decide(const FittedBoard& board, Identity& identity) const {
  const bool warned = identity.luminance_overlap > options_.max_luminance_overlap ||
                      identity.saturation_overlap > options_.max_saturation_overlap;
  const bool doubtful = identity.mixed_pixels > 0 || (identity.decoded && identity.decoded->bits_corrected > 0);
  identity.least_margin = !warned ? kLeastMargin : doubtful ? kLeastMarginDoubtful : kLeastMarginWarned;
  if (board.doubtful || CornersLieOff(board) || occlusion_.BelowBlack()) identity.least_margin = kLeastMarginDoubtful;
  identity.id_decided = identity.margin >= identity.least_margin;
}

bool Identifier::IsUnchecked(const Identity& identity) const {
  const MarkerCode& code = options_.families[static_cast<std::size_t>(identity.family)].code;
  return identity.cells_hidden > 2 * code.guaranteed_radius() &&
         std::max(identity.luminance_overlap, identity.saturation_overlap) > kMostOverlapUnchecked;
}

bool Identifier::MayLieElsewhere(MarkerSize size, const std::vector<std::uint8_t>& border) {
  cells_->saturated.resize(border.size());
  ForCells(size, [&](std::size_t cell, int row, int col) {
    const bool dark = IsDark(row, col);
    cells_->saturated[cell] = inks_.Of(dark).usable ? std::uint8_t{inks_.IsSaturated(cell, dark)} : kInkUntold;
  });
  return AgreesElsewhere(size, occlusion_.visibility().cells(), cells_->saturated, border);
}

Identifier::Reading Identifier::ReadingOf(MarkerSize size, Cell cell) const {
  const std::size_t i = static_cast<std::size_t>(cell.row * size.cols + cell.col);
  const bool dark = IsDark(cell.row, cell.col);
  Reading reading;
  reading.colour = inks_.ColourOf(i);
  reading.hidden = occlusion_.visibility().cells()[i];
  if (inks_.Of(dark).usable) reading.saturated = inks_.IsSaturated(i, dark);
  if (!IsBorder(size, cell.row, cell.col))
    reading.log_likelihood =
        cells_->log_likelihood[static_cast<std::size_t>((cell.row - 1) * (size.cols - 2) + cell.col - 1)];
  return reading;
}

Visibility Identifier::WhollyVisible() const {
  Visibility visible = occlusion_.visibility();
  for (std::size_t cell = 0; cell < visible.cells().size(); ++cell)
    if (occlusion_.ReachOf(cell) == Reach::kOver) visible.Hide(cell, Hidden::kOffColour);
  return visible;
}

void Identifier::MeasureOverlaps(MarkerSize size, Identity& identity) const {
  std::array<GaussianSum, 2> luminance, saturation;  // dark and light; unsaturated and saturated
  ForCells(size, [&](std::size_t cell, int row, int col) {
    if (!occlusion_.visibility().Shows(cell)) return;
    const bool dark = IsDark(row, col);
    luminance[dark].Add(inks_.ColourOf(cell).luminance);
    if (inks_.Of(dark).usable) saturation[inks_.IsSaturated(cell, dark)].Add(inks_.ColourOf(cell).saturation);
  });
  identity.luminance_overlap = Overlap(luminance[0].Get(), luminance[1].Get());
  identity.saturation_overlap = Overlap(saturation[0].Get(), saturation[1].Get());
}

Identity Identifier::Identify(const FittedBoard& board, MarkerSize size, const LightReader& reader, const Lens& lens) {
  Identity identity;
  const BoardInImage in{board, size, reader, lens};
  cells_.Start();
  inks_.Start();
  sampler_.Sample(in, cells_->lights);
  identity.mixed_pixels = cells_->lights.mixed_pixels;
  occlusion_.Find(board, size, cells_->lights.light);
  const auto of_size = std::ranges::find_if(options_.families, [&](const auto& f) { return f.code.size() == size; });
  const auto family = of_size - options_.families.begin();
  identity.family = static_cast<int>(family);
  const std::vector<std::uint8_t>& border = borders_[static_cast<std::size_t>(family)];
  identity.plausible = occlusion_.visibility().hidden_cells() * 2 <= size.rows * size.cols;
  const bool covered = !board.visibility.ShowsAllCorners();
  const ShownCells shown{size, border, cells_->lights, occlusion_.visibility()};
  identity.saturation_told = MeasureInks(shown);
  if (identity.saturation_told) {
    occlusion_.FindReached(in, cells_->lights.light);
    MeasureOverlaps(size, identity);
    WeighKernel(shown, identity);
    Decode(size, identity);
    Decide(board, identity);
    if (covered && (IsUnchecked(identity) || board.reprojection_rms_px > kMostOffCoveredPx))
      identity.id_decided = false;
  } else {
    identity.luminance_overlap = identity.saturation_overlap = 0.5;
  }
  if (covered && MayLieElsewhere(size, border)) {
    identity.id_decided = false;
    identity.plausible = false;
  }
  return identity;
}

}  // namespace chequer
