#include "detect/common/search_regions.h"

#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// If the regions cover more of the image, all of it is searched: that costs little more and needs no merging (a
/// guess).
constexpr double kMostInRegions = 0.6;
/// Rows that bands share with the next: corners at their ends are found with what lies around them, and rows begin at
/// whole pixels of the coarsest level.
constexpr int kSharedRows = 16, kWholeRows = 4;
/// A grid may go on beyond a region's end that is nearer than so much of its side (a guess).
constexpr float kNearEnd = 0.5f;

bool Overlap(const SearchRegion& a, const SearchRegion& b) {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

SearchRegion Union(const SearchRegion& a, const SearchRegion& b) {
  const int x = std::min(a.x, b.x), y = std::min(a.y, b.y);
  return {x, y, std::max(a.x + a.width, b.x + b.width) - x, std::max(a.y + a.height, b.y + b.height) - y};
}

}  // namespace

void SearchRegions::Start(int width, int height) {
  width_ = width;
  height_ = height;
  regions_.clear();
}

void SearchRegions::AddAll() { regions_.assign(1, {0, 0, width_, height_}); }

void SearchRegions::Add(const PixelBox& box) {
  const auto inside = [](float at, int size) {
    return static_cast<int>(std::clamp(at, 0.0f, static_cast<float>(size)));
  };
  const int left = inside(std::floor(box.left), width_), right = inside(std::ceil(box.right) + 1, width_),
            top = inside(std::floor(box.top), height_), bottom = inside(std::ceil(box.bottom) + 1, height_);
  if (left < right && top < bottom) regions_.push_back({left, top, right - left, bottom - top});
}

SearchRegion SearchRegions::BandOf(int band, int bands) const {
  const int top = band * height_ / bands - kSharedRows, bottom = (band + 1) * height_ / bands + kSharedRows;
  const int first = std::max(top, 0) / kWholeRows * kWholeRows;
  return {0, first, width_, std::min(bottom, height_) - first};
}

void SearchRegions::AddBand(int band, int bands) { regions_.push_back(BandOf(band, bands)); }

bool SearchRegions::HasBand(int band, int bands) const {
  const SearchRegion wanted = BandOf(band, bands);
  return std::any_of(regions_.begin(), regions_.end(), [&](const SearchRegion& region) {
    return region.width == width_ && region.y <= wanted.y && region.y + region.height >= wanted.y + wanted.height;
  });
}

bool SearchRegions::MayBeCut(const PixelBox& box, const SearchRegion& region) const {
  const float near = kNearEnd * box.Side(), above = box.top - static_cast<float>(region.y),
              below = static_cast<float>(region.y + region.height) - box.bottom;
  return (region.y > 0 && above < near) || (region.y + region.height < height_ && below < near);
}

std::int64_t SearchRegions::area() const {
  std::int64_t area = 0;
  for (const SearchRegion& region : regions_) area += region.area();
  return area;
}

void SearchRegions::Merge() {
  if (static_cast<double>(area()) > kMostInRegions * width_ * height_) return AddAll();
  for (std::size_t i = 0; i < regions_.size(); ++i)
    for (std::size_t k = i + 1; k < regions_.size();) {
      if (!Overlap(regions_[i], regions_[k])) {
        ++k;
        continue;
      }
      regions_[i] = Union(regions_[i], regions_[k]);
      regions_.erase(regions_.begin() + static_cast<std::ptrdiff_t>(k));
      // It may overlap now what it did not.
      k = i + 1;
    }
  if (static_cast<double>(area()) > kMostInRegions * width_ * height_) AddAll();
}

void KnownTiles::Start(int width, int height) {
  cols_ = (width + kTile - 1) / kTile;
  rows_ = (height + kTile - 1) / kTile;
  any_ = false;
}

void KnownTiles::Add(const std::array<Eigen::Vector2d, 4>& outline) {
  if (!any_) tiles_.assign(static_cast<std::size_t>(cols_) * static_cast<std::size_t>(rows_), false);
  any_ = true;
  Eigen::Vector2d least = outline[0], most = outline[0];
  for (const Eigen::Vector2d& corner : outline) {
    least = least.cwiseMin(corner);
    most = most.cwiseMax(corner);
  }
  if (!least.allFinite() || !most.allFinite()) return;
  const auto tile = [](double at, int count) {
    return static_cast<int>(std::clamp(at / kTile, 0.0, static_cast<double>(count - 1)));
  };
  // A row of tiles' middles crosses the outline from one column to another.
  for (int row = tile(least.y(), rows_); row <= tile(most.y(), rows_); ++row) {
    const double y = (row + 0.5) * kTile - 0.5;
    double left = most.x(), right = least.x();
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Eigen::Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
      if ((a.y() < y) == (b.y() < y)) continue;
      const double x = a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
      left = std::min(left, x), right = std::max(right, x);
    }
    const auto column = [](double x) { return (x + 0.5) / kTile - 0.5; };  // of tiles' middles
    // Within the image: outlines may reach far beyond it.
    const int first = static_cast<int>(std::clamp(std::ceil(column(left)), 0.0, 1.0 * cols_)),
              last = static_cast<int>(std::clamp(std::floor(column(right)), -1.0, cols_ - 1.0));
    const auto of_row = tiles_.begin() + std::ptrdiff_t{row} * cols_;
    if (first <= last) std::fill(of_row + first, of_row + last + 1, true);
  }
}

}  // namespace chequer
