#include "detect/identity/identify.h"

#include <algorithm>
#include <cmath>

#include "core/median.h"
#include "detect/common/cover.h"
#include "detect/common/homography.h"
#include "detect/identity/other_placements.h"

namespace chequer {
namespace {

/// How far a light cell's colour may lie from white and from yellow, as a share of their distance: farther off, it is
/// something else.
constexpr float kOffColour = 0.45f;
/// The largest log-likelihood ratio of one cell: a cell may be printed, dirty or lit wrongly whatever its noise says.
constexpr double kMostLikelihood = 12;
/// Least spread of the saturations about their means, as a share of the distance of the means: prints and lights vary.
constexpr double kLeastSpread = 0.07;
/// Cells besides a line of the board that no corner tells of, at most, where a line of it is occluded.
constexpr int kFewUnseen = 2;
/// Where cells are occluded, corners lie no farther off: else some are of the cover, measured 0.2 px; others 0.02 px.
constexpr double kMostOffCoveredPx = 0.08;
/// Least log-likelihood ratio of the best word over the second best.
constexpr double kLeastMargin = 6;
/// Where light or white balance are warned of, the margin has to be larger.
constexpr double kLeastMarginWarned = 9;
/// Where then a cell is corrected, too, it is one that disagrees, whatever the likelihoods say: of 2,100 ids of small
/// cells in JPEG of quality 60 the one wrong one had 10.7. And where cells had to be read together, JPEG's errors of
/// chroma reach from one to the next: four wrong ids of 840 boards of 4 px cells, quality 60 in 4:2:0, were of these.
constexpr double kLeastMarginDoubtful = 15;
/// The fewest cells for an estimate of the spread about the nearer mean.
constexpr int kFewestOfSpread = 4;

/// Light of a cell that is overexposed, and of boards that may have some.
constexpr float kOverexposed = 0.985f, kNearlyOverexposed = 0.85f;
/// Where the lightest cell's middle has less, no other is overexposed: cells of one ink differ by shading and noise.
constexpr float kMayBeOverexposed = 0.93f;

/// Blue's share of white's and so many times green's tell blue from black. The first is what −b* tells of, without the
/// cube root that makes the noise of black cells as large as blue, and of levels below zero none at all: a veil of
/// white light leaves it as it is. But where chroma is coarser or noisier than luma, sums have less noise than
/// differences. Of JPEG's 6 px cells in low light, half as many were wrong.
constexpr std::array<float, 3> kGreenWithBlue{-1, 0, 1};
/// Where a class's spread is below that share of the means' distance, the first measure is as good as any.
constexpr double kClearSpread = 0.12;

/// A dark cell that has so much more red light than the border's dark cells is under a veil of white light, such as the
/// mirror image of a lamp; as a share of the distance from black to blue. Less is noise.
constexpr double kClearVeil = 0.25;

float BlueOf(const Eigen::Vector3f& light, const Eigen::Vector3f& white, float green) {
  return light[2] / white[2] + green * light[1] / white[1];
}

/// Tells yellow from white: how much less blue there is than red and green, as shares of white's. A veil of white
/// light, such as the mirror image of a lamp, leaves it as it is.
float YellowOf(const Eigen::Vector3f& light, const Eigen::Vector3f& white) {
  return RedAndGreen::Of(light[0] / white[0], light[1] / white[1]) - light[2] / white[2];
}

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

}  // namespace

Identifier::Identifier(const DetectorOptions& options)
    : options_(options), rosters_(RostersOf(options)), borders_(BordersOf(options)) {}

void Identifier::ReadCells(const FittedBoard& board, MarkerSize size, const LightReader& reader, const Lens& lens) {
  const std::size_t cells = static_cast<std::size_t>(size.rows * size.cols);
  cells_->light.resize(cells);
  cells_->half_lit.assign(cells, 1.0f);
  cells_->veil.assign(cells, 0.0f);
  if (reader.channels() == 3) {
    // The fit's levels are free of what neighbours and the lens mix in.
    std::copy(board.levels.begin(), board.levels.end(), cells_->light.begin());
    ReadOverexposed(board, size, reader, lens);
    return;
  }
  if (!ReadSmallCells(board, size, reader, lens))
    for (std::size_t cell = 0; cell < cells; ++cell)
      cells_->light[cell] = MiddleLight(board, size, static_cast<int>(cell), reader, lens);
  if (!board.lit.empty()) EvenOutCells(board, size);
}

bool Identifier::ReadSmallCells(const FittedBoard& board, MarkerSize size, const LightReader& reader,
                                const Lens& lens) {
  // The homography from the cells, with a ring of others around the board, to the image, whatever the lens does.
  std::array<PointPair, 4> corners;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Eigen::Vector2d at(k % 2 == 0 ? 0 : size.cols, k / 2 == 0 ? 0 : size.rows);
    corners[k].from = at + Eigen::Vector2d::Ones();
    corners[k].to = lens.ToImage(board.geometry.ToPlane(at - 0.5 * Eigen::Vector2d(size.cols, size.rows)));
  }
  const double across = (corners[1].to - corners[0].to).norm() / size.cols,
               down = (corners[2].to - corners[0].to).norm() / size.rows;
  if (CellUnmixer::WindowsAreClear(reader, std::min(across, down), board.image.blur_px)) return false;
  const auto homography = FitHomography(corners);
  if (!homography) return false;
  const CellMesh mesh{*homography, size.rows + 2, size.cols + 2, static_cast<float>(board.image.blur_px)};
  cells_->unmixed.resize(static_cast<std::size_t>(mesh.rows * mesh.cols));
  const bool solved = unmixer_.Solve(reader, mesh, cells_->unmixed);
  cells_->mixed_pixels = unmixer_.pixels();
  if (!solved) return false;
  for (int row = 0; row < size.rows; ++row)
    for (int col = 0; col < size.cols; ++col)
      cells_->light[static_cast<std::size_t>(row * size.cols + col)] =
          cells_->unmixed[static_cast<std::size_t>((row + 1) * mesh.cols + col + 1)];
  return true;
}

Eigen::Vector3f Identifier::MiddleLight(const FittedBoard& board, MarkerSize size, int cell, const LightReader& reader,
                                        const Lens& lens) const {
  const Eigen::Vector2d at = MiddleOfCell(size, cell);
  Eigen::Matrix2d pixel_by_plane;
  const Eigen::Vector2d pixel = lens.ToImage(board.geometry.ToPlane(at), &pixel_by_plane);
  const Eigen::Matrix2d pixel_by_board = pixel_by_plane * board.geometry.PlaneByBoard(at);
  const double short_side =
      std::abs(pixel_by_board.determinant()) / std::max(pixel_by_board.col(0).norm(), pixel_by_board.col(1).norm());
  const double clear = std::clamp(0.5 * short_side - 1.2 * board.image.blur_px, 0.0, 0.35 * short_side);
  return reader.Rgb(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), static_cast<float>(clear));
}

void Identifier::ReadOverexposed(const FittedBoard& board, MarkerSize size, const LightReader& reader,
                                 const Lens& lens) {
  const auto brighter_than = [](float least) {
    return [least](const Eigen::Vector3f& light) { return light.maxCoeff() >= least; };
  };
  const auto middle = [&](std::size_t cell) { return MiddleLight(board, size, static_cast<int>(cell), reader, lens); };
  const auto lightest =
      std::max_element(cells_->light.begin(), cells_->light.end(),
                       [](const Eigen::Vector3f& a, const Eigen::Vector3f& b) { return a.maxCoeff() < b.maxCoeff(); });
  if (lightest == cells_->light.end() || !brighter_than(kNearlyOverexposed)(*lightest)) return;
  // A cell is overexposed as a whole: where the lightest ones' middles are not, none is.
  if (!brighter_than(kMayBeOverexposed)(middle(static_cast<std::size_t>(lightest - cells_->light.begin())))) return;
  cells_->middles.resize(cells_->light.size());
  for (std::size_t cell = 0; cell < cells_->light.size(); ++cell) cells_->middles[cell] = middle(cell);
  if (std::none_of(cells_->middles.begin(), cells_->middles.end(), brighter_than(kOverexposed))) return;
  cells_->light = cells_->middles;
  if (!board.lit.empty()) EvenOutCells(board, size);
}

void Identifier::EvenOutCells(const FittedBoard& board, MarkerSize size) {
  for (int row = 0; row < size.rows; ++row)
    for (int col = 0; col < size.cols; ++col) {
      const std::size_t cell = static_cast<std::size_t>(row * size.cols + col);
      const CellLight& lit = board.lit[cell];
      if (lit.most == 0) continue;
      Eigen::Vector3f& light = cells_->light[cell];
      if (!lit.crossed()) {
        light /= std::sqrt(lit.least * lit.most);
      } else if (!IsDark(row, col)) {
        // What was read lies to one side of a shadow's edge, or to both: its colour is the cell's in any case.
        const float read = RedAndGreen::Of(light[0], light[1]);
        if (read > 0) light *= board.levels[cell].sum() / read;
      } else {
        // Of dark cells the light that returns is too little to tell how much of it came.
        light /= lit.most;
        cells_->half_lit[cell] = lit.most / lit.least;
      }
    }
}

void Identifier::FindOccluded(const FittedBoard& board, MarkerSize size) {
  cells_->occluded.assign(cells_->light.size(), 1);
  // Seen are the cells around the corners that the model explains.
  for (int corner = 0; corner < CornerCount(size); ++corner) {
    if (!board.corner_used[static_cast<std::size_t>(corner)]) continue;
    for (const int cell : CellsAround(size, corner)) cells_->occluded[static_cast<std::size_t>(cell)] = 0;
  }
  // Of them, those that stand out from their neighbours as their class should.
  cells_->values.clear();
  for (const Eigen::Vector3f& light : cells_->light)
    cells_->values.push_back(std::sqrt(std::max(light[0] + light[1], 0.0f)));
  const auto value = [&](int cell) { return double{cells_->values[static_cast<std::size_t>(cell)]}; };
  std::array<double, 2> sums{};
  std::array<int, 2> cells{};
  for (int row = 0; row < size.rows; ++row)
    for (int col = 0; col < size.cols; ++col) {
      const int cell = row * size.cols + col;
      if (cells_->occluded[static_cast<std::size_t>(cell)]) continue;
      sums[IsDark(row, col)] += value(cell);
      ++cells[IsDark(row, col)];
    }
  const double contrast = sums[0] / std::max(cells[0], 1) - sums[1] / std::max(cells[1], 1);
  // Cells that no corner tells of may look like the board's: where they are but a line or so, only those that do not
  // are evidence of a cover. More of them lie under one.
  const auto unseen = std::count(cells_->occluded.begin(), cells_->occluded.end(), 1);
  cells_->wrong.assign(cells_->light.size(), 0);
  if (unseen > std::max(size.rows, size.cols) + kFewUnseen) cells_->wrong = cells_->occluded;
  cells_->seen.resize(cells_->occluded.size());
  for (std::size_t cell = 0; cell < cells_->occluded.size(); ++cell) cells_->seen[cell] = !cells_->occluded[cell];
  const std::span<const float> leads = cells_->neighbours.Of(size.rows, size.cols, cells_->values, cells_->seen);
  std::size_t cell = 0;
  for (int row = 0; row < size.rows; ++row)
    for (int col = 0; col < size.cols; ++col, ++cell) {
      const float lead = IsDark(row, col) ? -leads[cell] : leads[cell];
      cells_->wrong[cell] |= static_cast<std::uint8_t>(lead < 0.3 * contrast);
    }
  HideWrong(size);
}

bool Identifier::HideWrong(MarkerSize size) {
  HideBetween(size, cells_->wrong);
  bool found = false;
  for (std::size_t cell = 0; cell < cells_->occluded.size(); ++cell) {
    if (!cells_->wrong[cell] || cells_->occluded[cell]) continue;
    cells_->occluded[cell] = 1;
    found = true;
  }
  return found;
}

bool Identifier::HideOffColour(MarkerSize size, const std::vector<std::uint8_t>& border) {
  // Shares of the three channels, which shading leaves alone, of the light cells: white and yellow as the border has
  // them.
  cells_->shares.resize(cells_->light.size());
  for (std::size_t cell = 0; cell < cells_->light.size(); ++cell) {
    const Eigen::Vector3f light = cells_->light[cell].cwiseQuotient(cells_->white).cwiseMax(0);
    cells_->shares[cell] = light / std::max(light.sum(), 1e-6f);
  }
  std::array<Eigen::Vector3f, 2> middle;
  for (const std::uint8_t saturated : std::array<std::uint8_t, 2>{0, 1}) {
    cells_->known.clear();
    for (int row = 0; row < size.rows; ++row)
      for (int col = 0; col < size.cols; ++col) {
        const std::size_t cell = static_cast<std::size_t>(row * size.cols + col);
        if (IsBorder(size, row, col) && !IsDark(row, col) && !cells_->occluded[cell] && border[cell] == saturated)
          cells_->known.push_back(cell);
      }
    if (cells_->known.empty()) return false;
    for (int channel = 0; channel < 3; ++channel) {
      cells_->values.clear();
      for (const std::size_t cell : cells_->known) cells_->values.push_back(cells_->shares[cell][channel]);
      middle[saturated][channel] = MedianInPlace(cells_->values);
    }
  }
  const float most = kOffColour * (middle[1] - middle[0]).norm();
  for (int row = 0; row < size.rows; ++row)
    for (int col = 0; col < size.cols; ++col) {
      const std::size_t cell = static_cast<std::size_t>(row * size.cols + col);
      if (IsDark(row, col) || cells_->wrong[cell]) continue;
      const Eigen::Vector3f& share = cells_->shares[cell];
      if (std::min((share - middle[0]).norm(), (share - middle[1]).norm()) <= most) continue;
      cells_->wrong[cell] = 1;
    }
  return HideWrong(size);
}

bool Identifier::MeasureSaturation(MarkerSize size, const std::vector<std::uint8_t>& border) {
  Eigen::Vector3f& white = cells_->white;
  white.setZero();
  int whites = 0;
  for (int row = 0; row < size.rows; ++row)
    for (int col = 0; col < size.cols; ++col) {
      const std::size_t cell = static_cast<std::size_t>(row * size.cols + col);
      if (!IsBorder(size, row, col) || cells_->occluded[cell] || IsDark(row, col) || border[cell]) continue;
      white += cells_->light[cell];
      ++whites;
    }
  if (whites == 0) return false;
  white /= static_cast<float>(whites);
  if (!(white.minCoeff() > 1e-5f)) return false;
  cells_->colours.resize(cells_->light.size());
  cells_->ink.resize(cells_->light.size());
  for (int row = 0; row < size.rows; ++row)
    for (int col = 0; col < size.cols; ++col) {
      const std::size_t cell = static_cast<std::size_t>(row * size.cols + col);
      cells_->colours[cell] = ColourOf(cells_->light[cell], white, IsDark(row, col), options_.color_space);
      cells_->ink[cell] = cells_->colours[cell].saturation;
    }
  const bool lab = options_.color_space == ColorSpace::kLab;
  cells_->classes = {lab ? MeasureYellow(size, border) : ClassOf(size, border, false),
                     lab ? MeasureBlue(size, border) : ClassOf(size, border, true)};
  return cells_->classes[0].usable || cells_->classes[1].usable;
}

Identifier::Class Identifier::MeasureYellow(MarkerSize size, const std::vector<std::uint8_t>& border) {
  const Class by_saturation = ClassOf(size, border, false);
  if (by_saturation.usable && by_saturation.spread() < kClearSpread) return by_saturation;
  const auto fill = [&](const auto& ink_of) {
    for (int row = 0; row < size.rows; ++row)
      for (int col = 0; col < size.cols; ++col) {
        const std::size_t cell = static_cast<std::size_t>(row * size.cols + col);
        if (!IsDark(row, col)) cells_->ink[cell] = ink_of(cell);
      }
  };
  fill([&](std::size_t cell) { return YellowOf(cells_->light[cell], cells_->white); });
  const Class by_difference = ClassOf(size, border, false);
  if (by_difference.usable && (!by_saturation.usable || by_difference.spread() < by_saturation.spread()))
    return by_difference;
  fill([&](std::size_t cell) { return cells_->colours[cell].saturation; });
  return by_saturation;
}

Identifier::Class Identifier::MeasureBlue(MarkerSize size, const std::vector<std::uint8_t>& border) {
  const auto mix = [&](float green) {
    for (int row = 0; row < size.rows; ++row)
      for (int col = row % 2; col < size.cols; col += 2) {
        const std::size_t cell = static_cast<std::size_t>(row * size.cols + col);
        cells_->ink[cell] = BlueOf(cells_->light[cell], cells_->white, green);
      }
    return ClassOf(size, border, true);
  };
  float best_green = kGreenWithBlue[0], last = best_green;
  Class best = mix(best_green);
  if (best.usable && best.spread() < kClearSpread) return best;
  for (const float green : std::span(kGreenWithBlue).subspan(1)) {
    const Class other = mix(last = green);
    if (!other.usable || (best.usable && other.spread() >= best.spread())) continue;
    best = other;
    best_green = green;
  }
  if (last != best_green) best = mix(best_green);
  if (best.usable) MeasureVeils(size, best, best_green);
  return best;
}

void Identifier::MeasureVeils(MarkerSize size, const Class& dark, float green) {
  // Black and blue have as little red light as each other: what a cell has more is white light over it.
  const auto for_each_dark = [&](const auto& visit) {
    for (int row = 0; row < size.rows; ++row)
      for (int col = row % 2; col < size.cols; col += 2) {
        const std::size_t cell = static_cast<std::size_t>(row * size.cols + col);
        visit(cell, IsBorder(size, row, col), cells_->light[cell][0] / cells_->white[0]);
      }
  };
  cells_->values.clear();
  for_each_dark([&](std::size_t cell, bool border, float red) {
    if (border && !cells_->occluded[cell]) cells_->values.push_back(red);
  });
  const float usual = MedianInPlace(cells_->values), least = static_cast<float>(kClearVeil * (dark.inked - dark.plain));
  for_each_dark([&](std::size_t cell, bool, float red) {
    if (red - usual > least) cells_->veil[cell] = (1 + green) * (red - usual);
  });
}

Identifier::Class Identifier::ClassOf(MarkerSize size, const std::vector<std::uint8_t>& border, bool dark) const {
  std::array<GaussianSum, 2> groups;
  for (int row = 0; row < size.rows; ++row)
    for (int col = 0; col < size.cols; ++col) {
      const std::size_t cell = static_cast<std::size_t>(row * size.cols + col);
      if (IsDark(row, col) != dark || !IsBorder(size, row, col)) continue;
      if (!cells_->occluded[cell] && cells_->half_lit[cell] == 1) groups[border[cell]].Add(cells_->ink[cell]);
    }
  const Gaussian plain = groups[0].Get(), inked = groups[1].Get();
  Class c;
  c.usable = plain.count >= 2 && inked.count >= 2 && inked.mean > plain.mean;
  if (!c.usable) return c;
  c.plain = plain.mean;
  c.inked = inked.mean;
  const int freedom = plain.count + inked.count - 2;
  const double pooled =
      (plain.deviation * plain.deviation * (plain.count - 1) + inked.deviation * inked.deviation * (inked.count - 1)) /
      freedom;
  // Few cells tell their spread badly: a prior of two cells at the least spread.
  const double distance = c.inked - c.plain, least = kLeastSpread * distance;
  c.deviation = std::max(std::sqrt((pooled * freedom + 2 * least * least) / (freedom + 2)), least);
  // The kernel's cells may lie farther from the nearer mean: JPEG leaves other errors in each pattern of inks, and the
  // border's is regular. They decide a cell for less than it deserves, never for more.
  GaussianSum off;
  for (int row = 1; row + 1 < size.rows; ++row)
    for (int col = 1; col + 1 < size.cols; ++col) {
      const std::size_t cell = static_cast<std::size_t>(row * size.cols + col);
      if (IsDark(row, col) != dark || cells_->occluded[cell]) continue;
      const double ink = cells_->ink[cell];
      off.Add(std::abs(ink - c.plain) < std::abs(ink - c.inked) ? ink - c.plain : ink - c.inked);
    }
  const Gaussian kernel = off.Get();
  if (kernel.count < kFewestOfSpread) return c;
  const double square =
      kernel.mean * kernel.mean + kernel.deviation * kernel.deviation * (kernel.count - 1) / kernel.count;
  c.deviation = std::max(c.deviation, std::sqrt(square));
  return c;
}

void Identifier::Decode(MarkerSize size, Identity& identity) {
  cells_->log_likelihood.assign(static_cast<std::size_t>(KernelBits(size)), 0.0f);
  int i = 0;
  for (int row = 1; row + 1 < size.rows; ++row)
    for (int col = 1; col + 1 < size.cols; ++col, ++i) {
      const std::size_t cell = static_cast<std::size_t>(row * size.cols + col);
      const Class& c = cells_->classes[IsDark(row, col)];
      if (cells_->occluded[cell] || !c.usable) {
        ++identity.cells_hidden;
        continue;
      }
      const double distance = c.inked - c.plain;
      const double s = c.deviation / distance;
      // Of what it may be, what tells least.
      const auto lead_of = [&](double ink) { return (ink - c.plain) / distance - 0.5; };
      const double ink = cells_->ink[cell];
      double lead = lead_of(ink);
      for (const double other : {lead_of(cells_->half_lit[cell] * ink), lead_of(ink - cells_->veil[cell])})
        lead = lead * other <= 0 ? 0 : (std::abs(lead) < std::abs(other) ? lead : other);
      cells_->log_likelihood[static_cast<std::size_t>(i)] =
          static_cast<float>(std::clamp(lead / (s * s), -kMostLikelihood, kMostLikelihood));
    }
  double best_margin = -1;
  for (std::size_t f = 0; f < options_.families.size(); ++f) {
    const MarkerFamily& family = options_.families[f];
    if (!(family.code.size() == size)) continue;
    if (identity.family < 0) identity.family = static_cast<int>(f);
    const auto soft = family.code.DecodeSoft(cells_->log_likelihood, rosters_[f] ? &*rosters_[f] : nullptr);
    if (!soft) continue;
    if (soft->best.bits_corrected > family.code.guaranteed_radius()) {
      identity.cells_off = soft->best.bits_corrected;
      identity.cells_corrected = family.code.guaranteed_radius();
      continue;
    }
    if (soft->margin <= best_margin) continue;
    best_margin = soft->margin;
    identity.family = static_cast<int>(f);
    identity.decoded = soft->best;
  }
  const bool warned = identity.luminance_overlap > options_.max_luminance_overlap ||
                      identity.saturation_overlap > options_.max_saturation_overlap;
  identity.margin = best_margin;
  const bool doubtful = cells_->mixed_pixels > 0 || (identity.decoded && identity.decoded->bits_corrected > 0);
  identity.least_margin = !warned ? kLeastMargin : doubtful ? kLeastMarginDoubtful : kLeastMarginWarned;
  identity.id_decided = best_margin >= identity.least_margin;
}

bool Identifier::MayLieElsewhere(MarkerSize size, const std::vector<std::uint8_t>& border) {
  if (!cells_->classes[0].usable || !cells_->classes[1].usable) return false;
  cells_->saturated.resize(cells_->colours.size());
  for (std::size_t cell = 0; cell < cells_->colours.size(); ++cell) {
    const int row = static_cast<int>(cell) / size.cols, col = static_cast<int>(cell) % size.cols;
    const Class& c = cells_->classes[IsDark(row, col)];
    cells_->saturated[cell] = cells_->ink[cell] > (c.plain + c.inked) / 2;
  }
  return AgreesElsewhere(size, cells_->occluded, cells_->saturated, border);
}

Identifier::Reading Identifier::ReadingOf(MarkerSize size, Cell cell) const {
  const std::size_t i = static_cast<std::size_t>(cell.row * size.cols + cell.col);
  const Class& c = cells_->classes[IsDark(cell.row, cell.col)];
  Reading reading;
  reading.colour = cells_->colours[i];
  reading.occluded = cells_->occluded[i] != 0;
  if (c.usable) reading.saturated = cells_->ink[i] > (c.plain + c.inked) / 2;
  if (!IsBorder(size, cell.row, cell.col))
    reading.log_likelihood =
        cells_->log_likelihood[static_cast<std::size_t>((cell.row - 1) * (size.cols - 2) + cell.col - 1)];
  return reading;
}

void Identifier::MeasureOverlaps(MarkerSize size, Identity& identity) const {
  std::array<GaussianSum, 2> luminance, saturation;  // dark and light; unsaturated and saturated
  for (int row = 0; row < size.rows; ++row)
    for (int col = 0; col < size.cols; ++col) {
      const std::size_t cell = static_cast<std::size_t>(row * size.cols + col);
      if (cells_->occluded[cell]) continue;
      const bool dark = IsDark(row, col);
      luminance[dark].Add(cells_->colours[cell].luminance);
      const Class& c = cells_->classes[dark];
      if (!c.usable) continue;
      saturation[cells_->ink[cell] > (c.plain + c.inked) / 2].Add(cells_->colours[cell].saturation);
    }
  identity.luminance_overlap = Overlap(luminance[0].Get(), luminance[1].Get());
  identity.saturation_overlap = Overlap(saturation[0].Get(), saturation[1].Get());
}

Identity Identifier::Identify(const FittedBoard& board, MarkerSize size, const LightReader& reader, const Lens& lens) {
  Identity identity;
  cells_.Start();
  ReadCells(board, size, reader, lens);
  identity.mixed_pixels = cells_->mixed_pixels;
  FindOccluded(board, size);
  for (std::size_t f = 0; f < options_.families.size() && identity.family < 0; ++f)
    if (options_.families[f].code.size() == size) identity.family = static_cast<int>(f);
  const auto occluded = std::count(cells_->occluded.begin(), cells_->occluded.end(), 1);
  identity.plausible = occluded * 2 <= static_cast<std::ptrdiff_t>(cells_->occluded.size());
  const auto measured = [&](const std::vector<std::uint8_t>& border) {
    return MeasureSaturation(size, border) && (!HideOffColour(size, border) || MeasureSaturation(size, border));
  };
  if (identity.family < 0 || !measured(borders_[static_cast<std::size_t>(identity.family)])) {
    identity.luminance_overlap = identity.saturation_overlap = 0.5;
    return identity;
  }
  identity.saturation_told = true;
  MeasureOverlaps(size, identity);
  Decode(size, identity);
  const bool covered = board.corners_used < CornerCount(size);
  if (covered && board.reprojection_rms_px > kMostOffCoveredPx) identity.id_decided = false;
  if (covered && MayLieElsewhere(size, borders_[static_cast<std::size_t>(identity.family)])) {
    identity.id_decided = false;
    identity.plausible = false;
  }
  return identity;
}

}  // namespace chequer
