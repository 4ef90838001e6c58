#include "detect/grids/corner_search.h"

#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// Corners that are considered for one ray. Cells are empty but for noise, so that the neighbour is among the nearest
/// corners. In clutter, this bounds the work (a guess).
constexpr int kMostConsidered = 24;
/// Fewer corners are hardly ever enough: they are looked at together with those around them (a guess).
constexpr int kEnoughAtOnce = 16;
/// No ray is searched farther than so many times the nearest neighbour, as long as only one direction of the lattice
/// has one: seen at a slant, cells are that much longer than wide (guesses).
constexpr float kFarthestRatio = 3;
constexpr float kFarthestMore = 16;
/// With one in both directions, the opposite ones lie hardly farther (guesses).
constexpr float kOppositeRatio = 1.5f;
constexpr float kOppositeMore = 3;
/// Factor on the distance of corners on ridges: inside narrow cells, these lie nearer to a corner than its true
/// neighbour (a guess).
constexpr float kRidgeHandicap = 3;

/// So many corners, and so many a pixel, cost little in any case: frames of boards and textured ground mostly have
/// fewer (guesses).
constexpr std::size_t kFewCorners = 2000;
constexpr double kFewCornersPerPixel = 0.001;
/// The most pairs a pixel of the image: a thousand boards in 12 megapixels have a tenth of that.
constexpr double kMostPairs = 1;

/// How far there can be neighbours that matter.
float Sufficient(const NearestKeys& nearest) {
  std::array<float, 4> square;
  for (std::size_t ray = 0; ray < 4; ++ray) square[ray] = nearest.SquaredDistance(ray);
  const float farthest = std::sqrt(*std::max_element(square.begin(), square.end()));
  const float even = std::sqrt(std::min(square[0], square[2])), odd = std::sqrt(std::min(square[1], square[3]));
  if (std::max(even, odd) < CornerSearch::kLongest * kRidgeHandicap * 2)
    return std::min(farthest, kOppositeRatio * std::max(even, odd) + kOppositeMore);
  return std::min(farthest, kFarthestRatio * std::min(even, odd) + kFarthestMore);
}

}  // namespace

void CornerSearch::CountBuckets(int width, int height, int shift, const std::vector<Corner>& corners) {
  shift_ = shift;
  rings_ = kRingsOf[static_cast<std::size_t>(shift)];
  cols_ = (width >> shift) + 1;
  rows_ = (height >> shift) + 1;
  start_.assign(static_cast<std::size_t>(cols_ * rows_) + 1, 0);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    bucket_of_[i] = Row(corners[i].position.y()) * cols_ + Col(corners[i].position.x());
    ++start_[static_cast<std::size_t>(bucket_of_[i]) + 1];
  }
  for (std::size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
}

double CornerSearch::PairsInWindows() const {
  double pairs = 0;
  for (int row = 0; row < rows_; ++row)
    for (int col = 0; col < cols_; ++col)
      if (const int own = First(row, col + 1) - First(row, col); own > 0)
        pairs += static_cast<double>(own) * CountAround(row, col, kRings[0]);
  return pairs;
}

void CornerSearch::Build(int width, int height, std::vector<Corner>& corners) {
  const std::size_t count = corners.size();
  const double pixels = static_cast<double>(width) * height;
  count_ = static_cast<int>(count);
  groups_ = 0;
  bucket_of_.resize(count);
  int shift = kWidestShift;
  CountBuckets(width, height, shift, corners);
  if (count > kFewCorners && static_cast<double>(count) > kFewCornersPerPixel * pixels)
    while (shift > kNarrowestShift && PairsInWindows() > kMostPairs * pixels)
      CountBuckets(width, height, --shift, corners);
  next_.assign(start_.begin(), start_.end() - 1);
  sorted_.resize(count);
  for (std::size_t i = 0; i < count; ++i)
    sorted_[static_cast<std::size_t>(next_[static_cast<std::size_t>(bucket_of_[i])]++)] = corners[i];
  corners.swap(sorted_);
  table_.Resize(count);
  using T = CornerTable;
  for (std::size_t i = 0; i < count; ++i) {
    const Corner& corner = corners[i];
    const auto set = [&](T::Column column, float value) { table_.column(column)[i] = value; };
    set(T::kX, corner.position.x()), set(T::kY, corner.position.y());
    set(T::kRay0X, corner.rays[0].x()), set(T::kRay0Y, corner.rays[0].y());
    set(T::kRay1X, corner.rays[1].x()), set(T::kRay1Y, corner.rays[1].y());
    set(T::kContrast, corner.contrast);
    set(T::kHandicap, corner.ridge ? kRidgeHandicap * kRidgeHandicap : 1.0f);
  }
}

float CornerSearch::Covered(float x, float y, int row, int col, int ring) const {
  // From the point to the nearest side of the buckets around its own; the image's border hides nothing.
  const float size = static_cast<float>(1 << shift_);
  const auto to_side = [&](float at, int bucket, int buckets) {
    const float before = bucket - ring <= 0 ? 1e9f : at - static_cast<float>(bucket - ring) * size;
    const float after = bucket + ring >= buckets - 1 ? 1e9f : static_cast<float>(bucket + ring + 1) * size - at;
    return std::min(before, after);
  };
  return std::min(to_side(x, col, cols_), to_side(y, row, rows_));
}

int CornerSearch::CountAround(int row, int col, int ring) const {
  const int first_col = std::max(col - ring, 0), past_col = std::min(col + ring, cols_ - 1) + 1;
  int count = 0;
  for (int r = std::max(row - ring, 0); r <= std::min(row + ring, rows_ - 1); ++r)
    count += First(r, past_col) - First(r, first_col);
  return count;
}

std::size_t CornerSearch::StartBucket(int row, int col) {
  for (Window& window : windows_) window.filled = false;
  std::size_t size = 0;
  while (size + 1 < rings_ && CountAround(row, col, kRings[size]) < kEnoughAtOnce) ++size;
  return size;
}

const CornerSearch::Window& CornerSearch::WindowAround(int row, int col, std::size_t size) {
  Window& window = windows_[size];
  if (window.filled) return window;
  const int ring = kRings[size];
  const int first_col = std::max(col - ring, 0), past_col = std::min(col + ring, cols_ - 1) + 1;
  window.corners = 0;
  window.filled = true;
  std::size_t count = 0;
  for (int r = std::max(row - ring, 0); r <= std::min(row + ring, rows_ - 1); ++r) {
    const int first = First(r, first_col), past = First(r, past_col), length = past - first;
    window.corners += length;
    // Nearly every row has two ranges at most: then nothing branches on how many, which would be guessed wrong.
    const std::size_t ranges = static_cast<std::size_t>((length + kCornersAtOnce - 1) / kCornersAtOnce);
    if (window.ranges.size() < count + ranges + 2) window.ranges.resize(count + ranges + 2);
    window.ranges[count] = {first, past};
    window.ranges[count + 1] = {first + kCornersAtOnce, past};
    for (std::size_t k = 2; k < ranges; ++k)
      window.ranges[count + k] = {first + static_cast<int>(k) * kCornersAtOnce, past};
    count += ranges;
  }
  window.count = count;
  return window;
}

void CornerSearch::Find(int index, int row, int col, std::size_t size, NearestCorners& found) {
  // Wider windows look at the corners of the narrower ones again: they are few.
  const Window* window = &WindowAround(row, col, size);
  NearestKeys nearest = FindNearest(table_, index, window->Ranges(), kLongest);
  groups_ += window->count;
  while (window->corners <= kMostConsidered && size + 1 < rings_ &&
         Covered(X(index), Y(index), row, col, kRings[size]) < Sufficient(nearest)) {
    const int before = window->corners;
    window = &WindowAround(row, col, ++size);
    if (window->corners > before) nearest = FindNearest(table_, index, window->Ranges(), kLongest);
    groups_ += window->count;
  }
  for (std::size_t ray = 0; ray < 4; ++ray) {
    // Without branches: of none, the first.
    const int corner = nearest.Row(ray, window->ranges.data());
    found.corner[ray] = nearest.Found(ray) ? corner : -1;
    found.ray[ray] = static_cast<std::uint8_t>((ray + 1) % 2 + (nearest.LeadsBackByFirst(ray) ? 0 : 2));
  }
}

}  // namespace chequer
