// Where the cells of a lattice lie, what light they return, and which of them show a checkerboard.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "detect/boards/anchor.h"

namespace chequer {
namespace {

/// Half the side of the square that tells a cell's light: as a share of the cell, and at most so many pixels (guesses).
constexpr double kSampledShare = 0.3, kMostSampledPx = 2.5;
/// As CellMesh::blur_px, with what interpolation adds: 0.7 px to red and blue, half of that to green.
constexpr float kMosaicBlurPx = 1.0f;

}  // namespace

BoardFinder::Place BoardFinder::PlaceByHomography(int x, int y) const {
  const Eigen::Matrix3d& m = grid_->image_from_lattice;
  const Eigen::Vector3d at = m * Eigen::Vector3d(x + 0.5, y + 0.5, 1);
  const double scale = 1 / at.z();
  const Eigen::Vector2d center = scale * at.head<2>();
  // A cell's sides, to first order.
  const Eigen::Vector2d along_x = scale * (m.block<2, 1>(0, 0) - m(2, 0) * center),
                        along_y = scale * (m.block<2, 1>(0, 1) - m(2, 1) * center);
  const double area = std::abs(along_x.x() * along_y.y() - along_x.y() * along_y.x());
  const double square = std::max({along_x.squaredNorm(), along_y.squaredNorm(), 1e-18});
  return {center, area / std::sqrt(square)};
}

std::optional<BoardFinder::Place> BoardFinder::PlaceByNeighbours(int x, int y) const {
  const std::array<const Lattice::Point*, 4> around{grid_->lattice.At(x, y), grid_->lattice.At(x + 1, y),
                                                    grid_->lattice.At(x + 1, y + 1), grid_->lattice.At(x, y + 1)};
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
  const std::optional<Place> place = grid_->shared ? PlaceByHomography(x, y) : PlaceByNeighbours(x, y);
  sample.inside = place && place->center.x() >= 0 && place->center.y() >= 0 &&
                  place->center.x() <= reader.width() - 1 && place->center.y() <= reader.height() - 1;
  if (!sample.inside) return;
  const float half_px = static_cast<float>(std::min(kSampledShare * place->side, kMostSampledPx));
  sample.light = reader.RoughRgb(static_cast<float>(place->center.x()), static_cast<float>(place->center.y()), half_px)
                     .cwiseMax(0);
  sample.blue_share = sample.light[2] / std::max(sample.light.sum(), 1e-6f);
}

void BoardFinder::UnmixCells(const LightReader& reader) {
  grid_->mixed = grid_->small = false;
  const Lattice::Window& cells = grid_->cell_window;
  CellMesh mesh{.image_from_cells = grid_->image_from_lattice, .rows = cells.rows, .cols = cells.cols};
  if (reader.mosaic()) mesh.blur_px = kMosaicBlurPx;
  mesh.image_from_cells.col(2) +=
      cells.x * grid_->image_from_lattice.col(0) + cells.y * grid_->image_from_lattice.col(1);
  grid_->unmixed.resize(grid_->cells.size());
  const bool solved = unmixer_.Solve(reader, mesh, grid_->unmixed);
  grid_->work.Add(WorkStep::kMixedPixel, unmixer_.pixels());
  if (!solved) return;
  // The rim takes up what lies beside them.
  for (int y = 1; y + 1 < cells.rows; ++y)
    for (int x = 1; x + 1 < cells.cols; ++x) {
      const std::size_t cell = static_cast<std::size_t>(y * cells.cols + x);
      CellSample& sample = grid_->cells[cell];
      if (!sample.sampled) SampleCell(cells.x + x, cells.y + y, reader, sample);
      if (!sample.inside) continue;
      sample.light = grid_->unmixed[cell].cwiseMax(0);
      sample.blue_share = sample.light[2] / std::max(sample.light.sum(), 1e-6f);
    }
}

/// Neighbours leave the cells at the corners of a board out, and place others roughly.
void BoardFinder::ResampleByHomography(const Lattice::Window& window, const LightReader& reader) {
  if (grid_->shared) return;
  grid_->work.Add(WorkStep::kCellSample, static_cast<std::uint64_t>((window.cols + 1) * (window.rows + 1)));
  grid_->shared = true;
  for (int y = window.y - 1; y < window.y + window.rows; ++y)
    for (int x = window.x - 1; x < window.x + window.cols; ++x)
      SampleCell(x, y, reader, grid_->cells[grid_->Slot(x, y)]);
  grid_->shared = false;
}

void BoardFinder::MarkVisible(const Lattice::Window& window, const LightReader& reader) {
  grid_->marked = window;
  const int cols = window.cols + 1, rows = window.rows + 1;
  grid_->samples.resize(static_cast<std::size_t>(cols * rows));
  grid_->value.resize(grid_->samples.size());
  grid_->inside.resize(grid_->samples.size());
  grid_->work.Add(WorkStep::kWindowCell, grid_->samples.size());
  std::size_t cell = 0;
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col, ++cell) {
      grid_->samples[cell] = CellAt(window.x - 1 + col, window.y - 1 + row, reader);
      grid_->value[cell] = std::sqrt(grid_->samples[cell].light[0] + grid_->samples[cell].light[1]);
      grid_->inside[cell] = grid_->samples[cell].inside;
    }
  // How much lighter each cell is than its neighbours, in the measure that knows blue from black least. The sign is
  // that of the cell's class where the board is in view.
  const std::span<const float> leads = grid_->neighbours.Of(rows, cols, grid_->value, grid_->inside);
  grid_->sorted.clear();
  for (const float lead : leads) grid_->sorted.push_back(std::abs(lead));
  const auto upper = grid_->sorted.begin() + static_cast<std::ptrdiff_t>(grid_->sorted.size() * 2 / 3);
  std::nth_element(grid_->sorted.begin(), upper, grid_->sorted.end());
  const float least = 0.3f * *upper;
  // The lattice's cell (i, j) is light where i + j is even.
  grid_->visible.resize(grid_->samples.size());
  grid_->showing = 0;
  cell = 0;
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col, ++cell) {
      const bool dark = (window.x - 1 + col + window.y - 1 + row) % 2 != 0;
      grid_->visible[cell] =
          static_cast<std::uint8_t>(int{grid_->inside[cell] != 0} & int{(dark ? -leads[cell] : leads[cell]) > least});
      grid_->showing += grid_->visible[cell];
    }
}

}  // namespace chequer
