#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "detect/common/homography.h"
#include "detect/common/work_meter.h"
#include "detect/corners/corners.h"
#include "detect/grids/grids.h"

namespace chequer {

/// The corners of a grid by their place in its lattice, with those that linking missed but that lie where the lattice
/// goes on.
class Lattice {
 public:
  /// A corner of the lattice.
  struct Point {
    Eigen::Vector2d image = Eigen::Vector2d::Zero();  ///< pixels
    float scale = 1;
    int corner = 0;  ///< index
  };
  /// Rectangle of lattice points.
  struct Window {
    int x = 0, y = 0, cols = 0, rows = 0;

    bool operator==(const Window&) const = default;
  };

  /// Its corners lie within a quarter of a cell, at least 1 px, of one homography, at least three of four of any window
  /// that Fit() takes. False for a wall of tiles, too large for a board. @param most corners of the
  /// largest board along a side.
  /// @param search of the corners; null: they are few. @param claimed corners of boards that were found before, which
  /// belong to no other.
  bool Read(const Grid& grid, std::span<const LatticeCorner> members, const std::vector<Corner>& corners,
            const CornerSearch* search, std::span<const std::uint8_t> claimed, int width, int height, int most);

  /// Nothing where no corner was found.
  const Point* At(int x, int y) const {
    const int i = x < window_.x || y < window_.y || x >= window_.x + window_.cols || y >= window_.y + window_.rows
                      ? -1
                      : map_[Slot(x, y)];
    return i < 0 ? nullptr : &points_[static_cast<std::size_t>(i)];
  }
  const Window& window() const { return window_; }
  /// Corners in a window that lies within window().
  int Count(const Window& window) const {
    const int left = window.x - window_.x, top = window.y - window_.y;
    return Below(left + window.cols, top + window.rows) - Below(left, top + window.rows) -
           Below(left + window.cols, top) + Below(left, top);
  }

  /// The homography, image from lattice, of the corners in a window; corners that do not belong are left out. Nothing
  /// if too few agree. With `pairs`, those that do.
  std::optional<Eigen::Matrix3d> Fit(const Window& window, std::vector<PointPair>* pairs);

  /// What it took so far.
  const WorkMeter& work() const { return work_; }

 private:
  std::size_t Slot(int x, int y) const {
    return static_cast<std::size_t>((y - window_.y) * window_.cols + x - window_.x);
  }
  /// Corners in the first columns and rows of the window.
  int Below(int cols, int rows) const { return sums_[static_cast<std::size_t>(rows * (window_.cols + 1) + cols)]; }
  void SumUp();
  /// Whether all corners of a board with `most` along each side are there.
  bool HasWhole(int most) const;
  void Extend(const Eigen::Matrix3d& image_from_lattice, const std::vector<Corner>& corners, const CornerSearch* search,
              std::span<const std::uint8_t> claimed, int width, int height);

  Window window_;
  std::vector<int> map_;
  std::vector<int> sums_;
  std::vector<Point> points_;
  std::vector<PointPair> pairs_;
  WorkMeter work_;
};

}  // namespace chequer
