#include "detect/memory/expected_boards.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "detect/common/board_geometry.h"

namespace chequer {
namespace {

/// The search asks for as many border cells, and for this share of them to match.
constexpr int kFewestBorderCells = 9;
constexpr double kBorderShare = 0.85;
/// Of the contrast of a board, what a cell stands out from its neighbours by at least: cells in a shadow stand out by
/// half of it and more, what lies over a board by none.
constexpr float kLeastLead = 0.15f;
/// Of what a cell stood out by before, over what the board's others do now: what lies over a cell and its neighbours
/// leaves a third, a shadow's edge over a half.
constexpr float kLeastOfLead = 0.45f;
/// Fewer cells that do not show are the fit's to judge.
constexpr int kFewestOccluded = 3;
/// A cell whose log-likelihood speaks so much against the word contradicts it: one in a hundred of a clear board does.
/// Of two words, all but one of the cells that differ may be occluded: a single one ends what is carried.
constexpr double kContradiction = 4.6;

bool IsInside(const LightReader& reader, const Eigen::Vector2d& pixel) {
  return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= reader.width() - 1 && pixel.y() <= reader.height() - 1;
}

/// Which corners lie in the image, and the box around them. Returns how many.
int FindCorners(const BoardGeometry& geometry, const LightReader& reader, const Lens& lens, AnchoredBoard& board) {
  const int corners = CornerCount(board.size), cols = board.size.cols - 1;
  int found = 0;
  const auto look_for = [&](int corner) {
    const Eigen::Vector2d pixel =
        lens.ToImage(geometry.ToPlane(CornerOnBoard(board.size, corner / cols, corner % cols)));
    if (!pixel.allFinite() || !IsInside(reader, pixel)) return;
    board.found[static_cast<std::size_t>(corner)] = true;
    board.box.Add(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
    ++found;
  };
  for (const int outermost : {0, cols - 1, corners - cols, corners - 1}) look_for(outermost);
  if (found == 4) {
    // All others lie between them.
    std::fill_n(board.found.begin(), corners, true);
    return corners;
  }
  found = 0;
  for (int corner = 0; corner < corners; ++corner) look_for(corner);
  return found;
}

}  // namespace

ExpectedBoards::ExpectedBoards(const DetectorOptions& options) : options_(options) {
  for (const MarkerFamily& family : options.families) borders_.push_back(CellSaturation(family.code.size(), 0));
}

void ExpectedBoards::TellSaturation(const RememberedBoard& board, std::uint8_t* saturated) const {
  const std::size_t family = static_cast<std::size_t>(board.family);
  const MarkerSize size = options_.families[family].code.size();
  std::copy(borders_[family].begin(), borders_[family].end(), saturated);
  int bit = KernelBits(size);
  for (int row = 1; row < size.rows - 1; ++row)
    for (int col = 1; col < size.cols - 1; ++col) saturated[row * size.cols + col] = board.kernel >> --bit & 1;
}

bool ExpectedBoards::Expect(const RememberedBoard& remembered, const Eigen::Matrix3d& plane_from_board,
                            const LightReader& reader, const Lens& lens, AnchoredBoard& board) {
  board = {};
  board.size = options_.families[static_cast<std::size_t>(remembered.family)].code.size();
  board.plane_from_board = plane_from_board;
  board.scale = remembered.scale;
  const BoardGeometry geometry(plane_from_board);
  if (FindCorners(geometry, reader, lens, board) < FittedBoard::kFewestCorners) return false;
  board.box.Widen(1.0f / static_cast<float>(std::min(board.size.cols, board.size.rows) - 1));
  reader.Prefetch(board.box);
  const std::size_t cells = static_cast<std::size_t>(board.size.rows * board.size.cols);
  board.light.Assign(cells, Eigen::Vector3f::Zero());
  board.saturated.Assign(cells, 0);
  TellSaturation(remembered, board.saturated.data());
  board.visibility = Visibility(board.size);
  const Eigen::Matrix2d pixel_by_board = BoardPoint(geometry, lens).pixel_by_board;
  const float half_px = static_cast<float>(SampledHalfPx(pixel_by_board.colwise().norm().minCoeff()));
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const Eigen::Vector2d pixel = lens.ToImage(geometry.ToPlane(MiddleOfCell(board.size, static_cast<int>(cell))));
    if (!IsInside(reader, pixel)) {
      board.visibility.Hide(cell, Hidden::kOutside);
      continue;
    }
    board.light[cell] =
        reader.RoughRgb(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), half_px).cwiseMax(0);
  }
  return true;
}

void ExpectedBoards::MeasureLeads(const AnchoredBoard& board) {
  const MarkerSize size = board.size;
  std::array<float, kMaxCells> value;
  std::array<std::uint8_t, kMaxCells> counts;
  const std::size_t cells = board.light.size();
  float contrast = 0;
  const float per_cell = 2 / static_cast<float>(cells);
  ForCells(size, [&](std::size_t cell, int row, int col) {
    value[cell] = std::sqrt(std::max(board.light[cell][0] + board.light[cell][1], 0.0f));
    counts[cell] = board.visibility.Shows(cell);
    contrast += IsDark(row, col) ? -per_cell * value[cell] : per_cell * value[cell];
  });
  const std::span<const float> leads =
      neighbours_.Of(size.rows, size.cols, std::span(value).first(cells), std::span(counts).first(cells));
  const float of_contrast = 1 / std::max(contrast, 1e-6f);
  ForCells(size, [&](std::size_t cell, int row, int col) {
    leads_[cell] = (IsDark(row, col) ? -leads[cell] : leads[cell]) * of_contrast;
  });
}

void ExpectedBoards::LearnLeads(const AnchoredBoard& board, RememberedBoard& remembered) {
  MeasureLeads(board);
  remembered.leads.Assign(board.light.size(), 0.0f);
  std::copy_n(leads_.begin(), board.light.size(), remembered.leads.begin());
}

void ExpectedBoards::HideWhatDoesNotShow(const RememberedBoard& remembered, bool sharp, AnchoredBoard& board) {
  MeasureLeads(board);
  const std::size_t cells = board.light.size();
  const bool known = sharp && remembered.leads.size() == cells;
  // By how much it stood out before; where that is not known, a cell that was hidden is to stand out as others do.
  const auto stood_out = [&](std::size_t cell) { return known ? std::max(remembered.leads[cell], kLeastLead) : 1; };
  const auto was_hidden = [&](std::size_t cell) {
    return !remembered.visibility.Shows(cell) && remembered.visibility.cells()[cell] != Hidden::kOutside;
  };
  // What lies over a part of the board takes from its contrast: what shows stands out by as much more.
  float gain = 1;
  if (known || !remembered.visibility.ShowsAll()) {
    std::array<float, kMaxCells> gains;
    for (std::size_t cell = 0; cell < cells; ++cell) gains[cell] = leads_[cell] / stood_out(cell);
    const auto most = gains.begin() + static_cast<std::ptrdiff_t>(cells * 2 / 3);
    std::nth_element(gains.begin(), most, gains.begin() + static_cast<std::ptrdiff_t>(cells));
    gain = *most;
  }
  std::array<std::uint8_t, kMaxCells> shows;
  int occluded = 0;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const float of_lead = known || was_hidden(cell) ? kLeastOfLead * gain * stood_out(cell) : 0,
                least = std::max(kLeastLead, of_lead);
    shows[cell] = board.visibility.Shows(cell) && leads_[cell] >= least;
    occluded += !shows[cell];
  }
  if (occluded < kFewestOccluded) return;
  for (std::size_t cell = 0; cell < cells; ++cell)
    if (!shows[cell]) board.visibility.Hide(cell, Hidden::kFlat);
  board.visibility.HideEnclosed();
}

ExpectedBoards::Evidence ExpectedBoards::EvidenceOf(const RememberedBoard& remembered,
                                                    const Identifier& identifier) const {
  const MarkerSize size = options_.families[static_cast<std::size_t>(remembered.family)].code.size();
  std::array<std::uint8_t, kMaxCells> saturated;
  TellSaturation(remembered, saturated.data());
  Evidence evidence;
  ForCells(size, [&](std::size_t cell, int row, int col) {
    const Identifier::Reading reading = identifier.ReadingOf(size, {row, col});
    if (reading.hidden != Hidden::kNot) return;
    const bool is_saturated = saturated[cell] != 0;
    if (IsBorder(size, row, col)) {
      if (!reading.saturated) return;
      ++evidence.border_seen;
      evidence.border_matches += *reading.saturated == is_saturated;
    } else {
      const double for_word = is_saturated ? double{reading.log_likelihood} : -double{reading.log_likelihood};
      evidence.log_likelihood += for_word;
      evidence.contradictions += for_word < -kContradiction;
    }
  });
  return evidence;
}

bool AgreesWith(const ExpectedBoards::Evidence& evidence) {
  return evidence.border_seen >= kFewestBorderCells && evidence.border_matches >= kBorderShare * evidence.border_seen &&
         evidence.log_likelihood >= 0 && evidence.contradictions == 0;
}

}  // namespace chequer
