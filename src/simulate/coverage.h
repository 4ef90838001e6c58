#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace chequer {

/// A straight piece of a polygon's outline and what lies to its right: `weight` (red, green, blue and the covered
/// part), positive where the outline runs down the image.
struct OutlineEdge {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();  ///< pixels
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  Eigen::Array4f weight = Eigen::Array4f::Zero();
};

/// A raster into which outlines are drawn with the exact area that each pixel shares with each polygon, by Green's
/// theorem: every edge leaves, in each row it crosses, the area to its right; sums along the rows give the coverage.
/// Polygons that share an edge leave no seam.
class CoverageRaster {
 public:
  /// Empty. Pixel (i, j) covers [i, i+1] × [j, j+1] here: coordinates count from the raster's corner.
  void Reset(int width, int height);

  /// Adds the edge at (point − origin) · scale; parts beyond the raster count as far as they matter to it.
  void Add(const OutlineEdge& edge, const Eigen::Vector2d& origin, double scale);

  /// Sums up row y; once a row. The values are red, green, blue (each times coverage) and coverage. Valid until the
  /// next Reset.
  std::span<const Eigen::Array4f> IntegrateRow(int y);

  int width() const { return width_; }
  int height() const { return height_; }

 private:
  void AddClipped(double x0, double y0, double x1, double y1, const Eigen::Array4f& weight);
  void AddInRow(int row, double x0, double x1, double dy, const Eigen::Array4f& weight);

  int width_ = 0;
  int height_ = 0;
  std::vector<Eigen::Array4f> cells_;  ///< height × (width + 2); two more hold what falls right of the last pixel
};

}  // namespace chequer
