#include "detect/boards/lattice_cells.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "detect/common/board_geometry.h"

namespace chequer {
namespace {

/// As CellMesh::blur_px, with what interpolation adds: 0.7 px to red and blue, half of that to green.
constexpr float kMosaicBlurPx = 1.0f;
/// In narrower cells, half of what a window measures comes from their neighbours, by blur and interpolation (a guess).
constexpr double kSmallCellPx = 4;

}  // namespace

void LatticeCells::Start(const Lattice& lattice, const LightReader& reader) {
  lattice_ = &lattice;
  reader_ = &reader;
  const Lattice::Window& all = lattice.window();
  window_ = {all.x - 2, all.y - 2, all.cols + 3, all.rows + 3};
  cells_.assign(static_cast<std::size_t>(window_.cols * window_.rows), CellSample{});
}

void LatticeCells::PlaceOnPlane(const Eigen::Matrix3d& image_from_lattice) {
  on_plane_ = true;
  image_from_lattice_ = image_from_lattice;
  const Lattice::Window& all = lattice_->window();
  const double side = PlaceByHomography(all.x + all.cols / 2 - 1, all.y + all.rows / 2 - 1).side;
  mixed_ = !CellUnmixer::WindowsAreClear(*reader_, side, CellMesh{}.blur_px);
  small_ = !mixed_ && side < kSmallCellPx;
}

LatticeCells::Place LatticeCells::PlaceByHomography(int x, int y) const {
  const Eigen::Matrix3d& m = image_from_lattice_;
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

std::optional<LatticeCells::Place> LatticeCells::PlaceByNeighbours(int x, int y) const {
  const std::array<const Lattice::Point*, 4> around{lattice_->At(x, y), lattice_->At(x + 1, y),
                                                    lattice_->At(x + 1, y + 1), lattice_->At(x, y + 1)};
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

void LatticeCells::Sample(int x, int y, CellSample& sample) const {
  sample.sampled = true;
  const std::optional<Place> place = PlaceOf(x, y);
  sample.inside = place && place->center.x() >= 0 && place->center.y() >= 0 &&
                  place->center.x() <= reader_->width() - 1 && place->center.y() <= reader_->height() - 1;
  if (!sample.inside) return;
  const float half_px = static_cast<float>(SampledHalfPx(place->side));
  sample.light =
      reader_->RoughRgb(static_cast<float>(place->center.x()), static_cast<float>(place->center.y()), half_px)
          .cwiseMax(0);
  sample.blue_share = sample.light[2] / std::max(sample.light.sum(), 1e-6f);
}

void LatticeCells::Unmix(CellUnmixer& unmixer) {
  mixed_ = small_ = false;
  CellMesh mesh{.image_from_cells = image_from_lattice_, .rows = window_.rows, .cols = window_.cols};
  if (reader_->mosaic()) mesh.blur_px = kMosaicBlurPx;
  mesh.image_from_cells.col(2) += window_.x * image_from_lattice_.col(0) + window_.y * image_from_lattice_.col(1);
  unmixed_.resize(cells_.size());
  const bool solved = unmixer.Solve(*reader_, mesh, unmixed_);
  work_.Add(WorkStep::kMixedPixel, unmixer.pixels());
  if (!solved) return;
  // The rim takes up what lies beside them.
  for (int y = 1; y + 1 < window_.rows; ++y)
    for (int x = 1; x + 1 < window_.cols; ++x) {
      const std::size_t cell = static_cast<std::size_t>(y * window_.cols + x);
      CellSample& sample = cells_[cell];
      if (!sample.sampled) Sample(window_.x + x, window_.y + y, sample);
      if (!sample.inside) continue;
      sample.light = unmixed_[cell].cwiseMax(0);
      sample.blue_share = sample.light[2] / std::max(sample.light.sum(), 1e-6f);
    }
}

void LatticeCells::Resample(const Lattice::Window& window) {
  if (on_plane_) return;
  work_.Add(WorkStep::kCellSample, static_cast<std::uint64_t>((window.cols + 1) * (window.rows + 1)));
  on_plane_ = true;
  for (int y = window.y - 1; y < window.y + window.rows; ++y)
    for (int x = window.x - 1; x < window.x + window.cols; ++x) Sample(x, y, cells_[Slot(x, y)]);
  on_plane_ = false;
}

void LatticeCells::Look(const Lattice::Window& window, Footprint& footprint) {
  footprint.window = window;
  const int cols = window.cols + 1, rows = window.rows + 1;
  footprint.samples.resize(static_cast<std::size_t>(cols * rows));
  value_.resize(footprint.samples.size());
  inside_.resize(footprint.samples.size());
  work_.Add(WorkStep::kWindowCell, footprint.samples.size());
  std::size_t cell = 0;
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col, ++cell) {
      footprint.samples[cell] = At(window.x - 1 + col, window.y - 1 + row);
      value_[cell] = std::sqrt(footprint.samples[cell].light[0] + footprint.samples[cell].light[1]);
      inside_[cell] = footprint.samples[cell].inside;
    }
  // How much lighter each cell is than its neighbours, in the measure that knows blue from black least. The sign is
  // that of the cell's class where the board is in view.
  const std::span<const float> leads = neighbours_.Of(rows, cols, value_, inside_);
  sorted_.clear();
  for (const float lead : leads) sorted_.push_back(std::abs(lead));
  const auto upper = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() * 2 / 3);
  std::nth_element(sorted_.begin(), upper, sorted_.end());
  const float least = 0.3f * *upper;
  // The lattice's cell (i, j) is light where i + j is even.
  footprint.visible.resize(footprint.samples.size());
  footprint.showing = 0;
  cell = 0;
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col, ++cell) {
      const bool dark = (window.x - 1 + col + window.y - 1 + row) % 2 != 0;
      footprint.visible[cell] =
          static_cast<std::uint8_t>(int{inside_[cell] != 0} & int{(dark ? -leads[cell] : leads[cell]) > least});
      footprint.showing += footprint.visible[cell];
    }
}

}  // namespace chequer
