#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "detect/corners/corners.h"
#include "detect/grids/nearest_kernel.h"

namespace chequer {

/// The nearest corner along each ray of a corner, and its ray that leads back; −1 where there is none.
struct NearestCorners {
  std::array<int, 4> corner{-1, -1, -1, -1};
  std::array<std::uint8_t, 4> ray{};
};

/// Finds neighbours among the corners of an image, which it keeps by square buckets in arrays for vectors.
class CornerSearch {
 public:
  /// The longest link, image pixels (a guess).
  static constexpr float kLongest = 220;

  /// Sorts the corners by buckets and keeps what the search needs of them. Corners outside the image count to the
  /// bucket at its edge.
  void Build(int width, int height, std::vector<Corner>& corners);

  /// Fills place(i), a NearestCorners&, for every corner, in their order: the nearest corners that lie along the rays
  /// of corner i, are of similar contrast, and whose own ray that comes back is of the opposite kind: neighbouring
  /// corners swap light and dark, so an edge that leaves one by a rising ray comes in by a falling one. In clutter,
  /// gives up after a few dozen others. 0.08 µs a corner.
  template <class Place>
  void ForEach(const Place& place) {
    for (int first = 0; first < count_;) {
      const int row = Row(Y(first)), col = Col(X(first)), past = First(row, col + 1);
      const std::size_t size = StartBucket(row, col);
      for (; first < past; ++first) Find(first, row, col, size, place(first));
    }
  }

  /// Groups of kCornersAtOnce corners at most that a corner was held against, since Build(): what the search costs.
  std::uint64_t groups_looked_at() const { return groups_; }

  /// Calls visit(i) for the corners in the buckets that touch the square around a point.
  template <class Visit>
  void ForNeighbours(const Eigen::Vector2f& center, float radius, const Visit& visit) const {
    const int first_col = Col(center.x() - radius), last_col = Col(center.x() + radius);
    for (int row = Row(center.y() - radius); row <= Row(center.y() + radius); ++row)
      for (int i = First(row, first_col); i < First(row, last_col + 1); ++i) visit(i);
  }

 private:
  /// Sides of the buckets as powers of two, px. Where corners stand so close that a look at each takes too many others
  /// in, buckets are smaller.
  static constexpr int kWidestShift = 5, kNarrowestShift = 3;
  /// Half the sides of the windows around a bucket, buckets; the first that holds enough is searched first. The
  /// narrower the buckets, the more of them: kRingsOf many, of which the last reaches kLongest.
  static constexpr std::array<int, 6> kRings{1, 2, 4, 6, 13, 27};
  static constexpr std::array<std::size_t, 6> kRingsOf{0, 0, 0, 6, 5, 4};  ///< by the shift
  static_assert(kRings[kRingsOf[kWidestShift] - 1] == static_cast<int>(kLongest) >> kWidestShift);
  static_assert(kRings[kRingsOf[kNarrowestShift] - 1] == static_cast<int>(kLongest) >> kNarrowestShift);
  /// The corners around a bucket.
  struct Window {
    std::vector<CornerRange> ranges;  ///< the first `count` of them
    std::size_t count = 0;
    int corners = 0;
    bool filled = false;

    std::span<const CornerRange> Ranges() const { return std::span(ranges).first(count); }
  };
  /// Counts corners by buckets of that size.
  void CountBuckets(int width, int height, int shift, const std::vector<Corner>& corners);
  /// Pairs of corners that a search in the smallest windows takes in.
  double PairsInWindows() const;
  /// Forgets the windows of another bucket; returns the size that the search of this one begins with.
  std::size_t StartBucket(int row, int col);
  int CountAround(int row, int col, int ring) const;
  const Window& WindowAround(int row, int col, std::size_t size);
  /// @param size of the window to begin with.
  void Find(int index, int row, int col, std::size_t size, NearestCorners& found);

  float X(int i) const { return table_.column(CornerTable::kX)[i]; }
  float Y(int i) const { return table_.column(CornerTable::kY)[i]; }
  int Col(float x) const { return std::clamp(static_cast<int>(x) >> shift_, 0, cols_ - 1); }
  int Row(float y) const { return std::clamp(static_cast<int>(y) >> shift_, 0, rows_ - 1); }
  /// How far around a point all corners lie in its bucket and the `ring` buckets around it, pixels.
  float Covered(float x, float y, int row, int col, int ring) const;
  /// First corner of a bucket; those of a row's buckets stand one after the other.
  int First(int row, int col) const { return start_[static_cast<std::size_t>(row * cols_ + col)]; }

  int cols_ = 0, rows_ = 0, count_ = 0;
  std::uint64_t groups_ = 0;
  int shift_ = kWidestShift;
  std::size_t rings_ = kRingsOf[kWidestShift];
  std::vector<int> start_, next_, bucket_of_;
  std::vector<Corner> sorted_;
  CornerTable table_;
  std::array<Window, kRings.size()> windows_;
};

}  // namespace chequer
