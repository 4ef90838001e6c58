#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace chequer {

/// Points of an image sorted into square buckets, for asking who is near. Keeps its memory.
class Buckets {
 public:
  static constexpr int kShift = 4;  ///< buckets of 16 × 16 px

  /// Sorts points 0 … count − 1. Points outside the image count to the bucket at its edge.
  template <class PositionOf>
  void Build(int width, int height, int count, const PositionOf& position_of) {
    cols_ = (width >> kShift) + 1;
    rows_ = (height >> kShift) + 1;
    start_.assign(static_cast<std::size_t>(cols_ * rows_) + 1, 0);
    of_point_.resize(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
      const int bucket = BucketOf(position_of(i));
      of_point_[static_cast<std::size_t>(i)] = bucket;
      ++start_[static_cast<std::size_t>(bucket) + 1];
    }
    for (std::size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
    points_.resize(static_cast<std::size_t>(count));
    fill_.assign(start_.begin(), start_.end() - 1);
    for (int i = 0; i < count; ++i)
      points_[static_cast<std::size_t>(fill_[static_cast<std::size_t>(of_point_[static_cast<std::size_t>(i)])]++)] = i;
  }

  int Col(float x) const { return std::clamp(static_cast<int>(x) >> kShift, 0, cols_ - 1); }
  int Row(float y) const { return std::clamp(static_cast<int>(y) >> kShift, 0, rows_ - 1); }
  int cols() const { return cols_; }
  int rows() const { return rows_; }

  /// Points of the buckets from first_col to last_col of a row. @pre columns and row in range.
  std::span<const int> InRow(int row, int first_col, int last_col) const {
    const std::size_t begin = static_cast<std::size_t>(start_[static_cast<std::size_t>(row * cols_ + first_col)]);
    const std::size_t end = static_cast<std::size_t>(start_[static_cast<std::size_t>(row * cols_ + last_col) + 1]);
    return std::span(points_).subspan(begin, end - begin);
  }

 private:
  int BucketOf(const Eigen::Vector2f& p) const { return Row(p.y()) * cols_ + Col(p.x()); }

  int cols_ = 0, rows_ = 0;
  std::vector<int> start_, fill_, of_point_, points_;
};

}  // namespace chequer
