// What the search for boards says of an attempt that failed; runs only where somebody asks.
#include <cmath>

#include "detect/boards/placement.h"
#include "detect/common/board_geometry.h"
#include "detect/common/colours.h"

namespace chequer {

namespace {

std::array<Eigen::Vector2f, 4> OutlineOf(const LatticeCells& cells, const LatticeCells::Place& place, int x, int y) {
  std::array<Eigen::Vector2f, 4> outline;
  constexpr std::array<int, 4> kRight{0, 1, 1, 0}, kDown{0, 0, 1, 1};
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d at(x + kRight[k], y + kDown[k]);
    // Without a plane, roughly.
    const Eigen::Vector2d beside = place.side / 3 * Eigen::Vector2d(2 * kRight[k] - 1, 2 * kDown[k] - 1);
    Eigen::Vector2d pixel = place.center + beside;
    if (cells.on_plane()) pixel = (cells.image_from_lattice() * at.homogeneous()).hnormalized();
    outline[k] = pixel.cast<float>();
  }
  return outline;
}

/// Where the footprint lies, before its cells are placed anew.
const CellSample& SampleOf(const Placement& placement, const LatticeCells& cells, const Cell& in_footprint) {
  return cells.Known(placement.corners.x - 1 + in_footprint.col, placement.corners.y - 1 + in_footprint.row);
}

/// White as the border would have it; as the lightest cell where it has none.
Eigen::Vector3f WhiteAround(const Placement& placement, const LatticeCells& cells,
                            const std::vector<std::uint8_t>& border) {
  const MarkerSize size = placement.pattern->size;
  Eigen::Vector3f white = Eigen::Vector3f::Zero(), lightest = Eigen::Vector3f::Constant(1e-4f);
  int whites = 0;
  ForCells(size, [&](std::size_t cell, int row, int col) {
    const CellSample& sample = SampleOf(placement, cells, InFootprint(size, row, col, placement.turn));
    if (!sample.inside) return;
    lightest = lightest.cwiseMax(sample.light);
    if (!IsBorder(size, row, col) || IsDark(row, col) || border[cell]) return;
    white += sample.light;
    ++whites;
  });
  if (whites > 0) white /= static_cast<float>(whites);
  return white.minCoeff() > 1e-4f ? white : lightest;
}

void TraceCells(const Placement& placement, const LatticeCells& cells, const Footprint& footprint, ColorSpace space,
                TraceCandidate& attempt) {
  const MarkerSize size = attempt.size = placement.pattern->size;
  const std::vector<std::uint8_t> border = CellSaturation(size, 0);
  const int cols = placement.cols(), rows = placement.rows();
  const Eigen::Vector3f white = WhiteAround(placement, cells, border);
  // The window was marked for the last placement that was tried in it, which this is.
  const bool marked =
      footprint.samples.size() == static_cast<std::size_t>(rows * cols) && attempt.refusal < Refusal::kRivalled;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int placed = 0;
  std::array<std::array<GaussianSum, 2>, 2> groups;  // [dark][saturated], of the border
  ForCells(size, [&](std::size_t index, int row, int col) {
    const Cell in_footprint = InFootprint(size, row, col, placement.turn);
    const CellSample& sample = SampleOf(placement, cells, in_footprint);
    TraceCell cell;
    cell.at = {row, col};
    const int x = placement.corners.x - 1 + in_footprint.col, y = placement.corners.y - 1 + in_footprint.row;
    if (const auto place = cells.PlaceOf(x, y)) {
      cell.center_px = place->center;
      cell.outline_px = OutlineOf(cells, *place, x, y);
      sum += cell.center_px;
      ++placed;
    }
    cell.seen =
        sample.inside &&
        (!marked || footprint.visible[static_cast<std::size_t>(in_footprint.row * cols + in_footprint.col)] != 0);
    const CellColour colour = ColourOf(sample.light, white, cell.dark(), space);
    cell.luminance = colour.luminance;
    cell.saturation = colour.saturation;
    if (IsBorder(size, row, col)) cell.expected = border[index] != 0;
    if (cell.expected && cell.seen) groups[cell.dark()][*cell.expected].Add(cell.saturation);
    attempt.cells.push_back(cell);
  });
  for (TraceCell& cell : attempt.cells) {
    const double plain = groups[cell.dark()][0].Get().mean, inked = groups[cell.dark()][1].Get().mean;
    if (cell.seen && inked > plain) cell.saturated = cell.saturation > (plain + inked) / 2;
  }
  attempt.center_px = sum / std::max(placed, 1);
}

}  // namespace

void NoteAttempt(const Placement& placement, const Verdict& verdict, const LatticeCells& cells,
                 const Footprint& footprint, ColorSpace space, TraceCandidate& best) {
  // Placements under something are tried after plain ones, with more to prove: they explain nothing.
  if (placement.covered.lines > 0) return;
  const auto share = [](double part, double whole) { return whole > 0 ? part / whole : 0; };
  if (verdict.why < best.refusal ||
      (verdict.why == best.refusal && share(verdict.measured, verdict.required) <= share(best.measured, best.required)))
    return;
  best.refusal = verdict.why;
  best.measured = verdict.measured;
  best.required = verdict.required;
  best.cells.clear();
  if (verdict.why >= Refusal::kNoYellow) TraceCells(placement, cells, footprint, space, best);
}

}  // namespace chequer
