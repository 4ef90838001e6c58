#include "detect/boards/lattice.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// Larger grids are no boards: a wall of tiles (a guess).
constexpr int kMostLattice = 160;
/// Lattice points around a grid that are looked at in any case (a guess).
constexpr int kBeyond = 2;
/// A corner belongs to a lattice point if it lies nearer than this share of a cell, or than so many pixels (guesses).
constexpr double kBelongs = 0.25, kBelongsPx = 1;
/// Share of the corners of a window that may lie elsewhere (a guess).
constexpr double kMostOutliers = 0.25;

/// Side of the cell around a lattice point in the image, pixels: the shorter of the two.
double CellSide(const Eigen::Matrix3d& image_from_lattice, const Eigen::Vector2d& at) {
  const Eigen::Vector3d h = image_from_lattice * at.homogeneous();
  const Eigen::Vector2d p = h.hnormalized();
  const Eigen::Matrix2d derivative =
      (image_from_lattice.topLeftCorner<2, 2>() - p * image_from_lattice.block<1, 2>(2, 0)) / h.z();
  return std::min(derivative.col(0).norm(), derivative.col(1).norm());
}

double Reach(const Eigen::Matrix3d& image_from_lattice, const Eigen::Vector2d& at) {
  return std::max(kBelongs * CellSide(image_from_lattice, at), kBelongsPx);
}

}  // namespace

bool Lattice::Read(const Grid& grid, std::span<const LatticeCorner> members, const std::vector<Corner>& corners,
                   const CornerSearch* search, std::span<const std::uint8_t> claimed, int width, int height, int most) {
  const int cols = grid.max_x - grid.min_x + 1, rows = grid.max_y - grid.min_y + 1;
  if (cols > kMostLattice || rows > kMostLattice) return false;
  // A board's corners may lie that far beyond the grid: what was linked may be a part of them and some clutter.
  const bool exact = cols == most && rows == most && static_cast<int>(members.size()) == cols * rows;
  const int beyond_x = exact ? 0 : std::max(most - cols, kBeyond),
            beyond_y = exact ? 0 : std::max(most - rows, kBeyond);
  window_ = {grid.min_x - beyond_x, grid.min_y - beyond_y, cols + 2 * beyond_x, rows + 2 * beyond_y};
  map_.assign(static_cast<std::size_t>(window_.cols * window_.rows), -1);
  work_.Add(WorkStep::kGrid);
  work_.Add(WorkStep::kLatticePoint, map_.size());
  points_.clear();
  for (const LatticeCorner& at : members) {
    int& slot = map_[Slot(at.x, at.y)];
    if (slot >= 0 || claimed[static_cast<std::size_t>(at.corner)]) continue;
    const Corner& corner = corners[static_cast<std::size_t>(at.corner)];
    slot = static_cast<int>(points_.size());
    points_.push_back({corner.position.cast<double>(), corner.scale, at.corner});
  }
  if (static_cast<int>(points_.size()) < GridLinker::kFewest) return false;
  SumUp();
  // With a whole board among so few, there is nothing to look for.
  if (cols <= most + kBeyond && rows <= most + kBeyond && !HasWhole(most)) {
    if (const auto image_from_lattice = Fit({grid.min_x, grid.min_y, cols, rows}, nullptr))
      Extend(*image_from_lattice, corners, search, claimed, width, height);
    SumUp();
  }
  return true;
}

bool Lattice::HasWhole(int most) const {
  Window window{0, 0, most, most};
  for (window.y = window_.y; window.y + most <= window_.y + window_.rows; ++window.y)
    for (window.x = window_.x; window.x + most <= window_.x + window_.cols; ++window.x)
      if (Count(window) == most * most) return true;
  return false;
}

void Lattice::SumUp() {
  sums_.assign(static_cast<std::size_t>((window_.cols + 1) * (window_.rows + 1)), 0);
  for (int y = 0; y < window_.rows; ++y) {
    int row = 0;
    for (int x = 0; x < window_.cols; ++x) {
      row += map_[static_cast<std::size_t>(y * window_.cols + x)] >= 0;
      sums_[static_cast<std::size_t>((y + 1) * (window_.cols + 1) + x + 1)] = Below(x + 1, y) + row;
    }
  }
}

void Lattice::Extend(const Eigen::Matrix3d& image_from_lattice, const std::vector<Corner>& corners,
                     const CornerSearch* search, std::span<const std::uint8_t> claimed, int width, int height) {
  for (int y = window_.y; y < window_.y + window_.rows; ++y)
    for (int x = window_.x; x < window_.x + window_.cols; ++x) {
      if (map_[Slot(x, y)] >= 0) continue;
      const Eigen::Vector2d at(x, y);
      const Eigen::Vector3d h = image_from_lattice * at.homogeneous();
      if (!(h.z() > 0)) continue;
      const Eigen::Vector2d p = h.hnormalized();
      if (!(p.x() >= 0 && p.y() >= 0 && p.x() < width && p.y() < height)) continue;
      work_.Add(WorkStep::kLatticeSearch);
      const float reach = static_cast<float>(Reach(image_from_lattice, at));
      const Eigen::Vector2f center = p.cast<float>();
      float nearest = reach * reach;
      int best = -1;
      int others = 0;
      const auto look_at = [&](int i) {
        ++others;
        const float square = (corners[static_cast<std::size_t>(i)].position - center).squaredNorm();
        if (square < nearest && !claimed[static_cast<std::size_t>(i)]) nearest = square, best = i;
      };
      if (search) search->ForNeighbours(center, reach, look_at);
      for (int i = 0; !search && i < static_cast<int>(corners.size()); ++i) look_at(i);
      work_.Add(WorkStep::kComparison, static_cast<std::uint64_t>(others));
      if (best < 0) continue;
      const Corner& corner = corners[static_cast<std::size_t>(best)];
      map_[Slot(x, y)] = static_cast<int>(points_.size());
      points_.push_back({corner.position.cast<double>(), corner.scale, best});
    }
}

std::optional<Eigen::Matrix3d> Lattice::Fit(const Window& window, std::vector<PointPair>* pairs) {
  pairs_.clear();
  for (int y = window.y; y < window.y + window.rows; ++y)
    for (int x = window.x; x < window.x + window.cols; ++x)
      if (const Point* point = At(x, y)) pairs_.push_back({Eigen::Vector2d(x, y), point->image});
  const std::size_t fewest = std::max<std::size_t>(
      GridLinker::kFewest,
      static_cast<std::size_t>(std::ceil((1 - kMostOutliers) * static_cast<double>(pairs_.size()))));
  while (pairs_.size() >= fewest) {
    work_.Add(WorkStep::kFitPoint, pairs_.size());
    const auto homography = FitHomography(pairs_);
    if (!homography) return std::nullopt;
    // The worst goes until all belong.
    double worst = 1;
    std::size_t worst_index = pairs_.size();
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const double distance = ((*homography * pairs_[i].from.homogeneous()).hnormalized() - pairs_[i].to).norm();
      // Nearly always.
      if (distance <= kBelongsPx) continue;
      const double error = distance / Reach(*homography, pairs_[i].from);
      if (error > worst) worst = error, worst_index = i;
    }
    if (worst_index == pairs_.size()) {
      if (pairs) *pairs = pairs_;
      return homography;
    }
    pairs_.erase(pairs_.begin() + static_cast<std::ptrdiff_t>(worst_index));
  }
  return std::nullopt;
}

}  // namespace chequer
