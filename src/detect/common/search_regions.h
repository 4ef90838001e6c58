#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "detect/common/light.h"

namespace chequer {

/// A rectangle of whole pixels of an image.
struct SearchRegion {
  int x = 0, y = 0, width = 0, height = 0;

  std::int64_t area() const { return std::int64_t{width} * height; }
};

/// The parts of an image that are searched for boards.
class SearchRegions {
 public:
  /// In one of so many bands, two rows of a board's corners lie at least, wherever and however large it is.
  static constexpr int kMostBands = 4;

  void Start(int width, int height);
  /// The whole image.
  void AddAll();
  /// What of the box lies in the image.
  void Add(const PixelBox& box);
  /// One of kMostBands bands of rows, or of fewer, that the image is cut into, and what overlaps with the next.
  void AddBand(int band, int bands);
  /// Whether that band lies in one of the regions.
  bool HasBand(int band, int bands) const;
  /// Makes one of regions that overlap, and the whole image of many.
  void Merge();
  const std::vector<SearchRegion>& regions() const { return regions_; }
  std::int64_t area() const;
  int width() const { return width_; }
  int height() const { return height_; }
  /// Whether it is the whole image.
  bool is_all() const { return area() == std::int64_t{width_} * height_; }
  /// Whether a box in that region may be a part of what lies beyond its upper or lower end in the image.
  bool MayBeCut(const PixelBox& box, const SearchRegion& region) const;

 private:
  SearchRegion BandOf(int band, int bands) const;

  int width_ = 0, height_ = 0;
  std::vector<SearchRegion> regions_;
};

/// Where boards are known to lie, by tiles of the image: what looks like a corner there is one of theirs.
class KnownTiles {
 public:
  static constexpr int kTile = 4;

  /// Nothing is known.
  void Start(int width, int height);
  /// @param outline of a board, pixels, round it.
  void Add(const std::array<Eigen::Vector2d, 4>& outline);
  bool Covers(const Eigen::Vector2f& at) const {
    if (!any_) return false;
    const int col = static_cast<int>(at.x()) / kTile, row = static_cast<int>(at.y()) / kTile;
    if (col < 0 || row < 0 || col >= cols_ || row >= rows_) return false;
    return tiles_[static_cast<std::size_t>(row * cols_ + col)];
  }
  bool any() const { return any_; }

 private:
  int cols_ = 0, rows_ = 0;
  bool any_ = false;
  std::vector<bool> tiles_;  ///< bits, of which a thousand lie near
};

}  // namespace chequer
