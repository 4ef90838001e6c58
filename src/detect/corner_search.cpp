#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/corner_search.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include <cstdint>

#ifndef CHEQUER_DETECT_CORNER_SEARCH
#define CHEQUER_DETECT_CORNER_SEARCH
namespace chequer {
namespace search {

/// The corners' arrays, readable up to a vector beyond their ends.
struct Arrays {
  const float *x, *y, *ray0_x, *ray0_y, *ray1_x, *ray1_y, *contrast;
};

/// The best so far, by ray.
struct Best {
  float cost[4];
  int corner[4];
  int ray[4];
};

/// Squared cosine of how far the neighbour may lie off the ray (25 degrees), at both ends.
constexpr float kLeastSquaredCosine = 0.906f * 0.906f;
/// How much more a candidate that lies off the ray has to be nearer.
constexpr float kOffAxisCost = 3;
/// Contrasts of neighbours differ less.
constexpr float kMostContrastRatio = 4;
/// Nearer corners are one and the same, px.
constexpr float kShortest = 2;

}  // namespace search
}  // namespace chequer
#endif  // CHEQUER_DETECT_CORNER_SEARCH

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Looks from the corner `from` at the corners of `rows` ranges, each given by its first and the one past its last.
void Consider(const search::Arrays& in, int from, const int (*ranges)[2], int rows, float longest, search::Best& best) {
  // A row's range is short: longer vectors would be empty for the most part.
  constexpr std::size_t kMaxLanes = 8;
  const hn::CappedTag<float, kMaxLanes> d;
  using V = hn::Vec<decltype(d)>;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V x = hn::Set(d, in.x[from]), y = hn::Set(d, in.y[from]);
  const V ray0_x = hn::Set(d, in.ray0_x[from]), ray0_y = hn::Set(d, in.ray0_y[from]);
  const V ray1_x = hn::Set(d, in.ray1_x[from]), ray1_y = hn::Set(d, in.ray1_y[from]);
  const V least_contrast = hn::Set(d, in.contrast[from] / search::kMostContrastRatio);
  const V most_contrast = hn::Set(d, in.contrast[from] * search::kMostContrastRatio);
  const V nearest = hn::Set(d, search::kShortest * search::kShortest), farthest = hn::Set(d, longest * longest);
  const V cosine = hn::Set(d, search::kLeastSquaredCosine);
  for (int row = 0; row < rows; ++row) {
    const int last = ranges[row][1];
    for (int i = ranges[row][0]; i < last; i += lanes) {
      const V dx = hn::Sub(hn::LoadU(d, in.x + i), x), dy = hn::Sub(hn::LoadU(d, in.y + i), y);
      const V square = hn::MulAdd(dx, dx, hn::Mul(dy, dy));
      const V least = hn::Mul(square, cosine);
      // Along the rays of the one, and of the other.
      const V along0 = hn::MulAdd(ray0_x, dx, hn::Mul(ray0_y, dy)),
              along1 = hn::MulAdd(ray1_x, dx, hn::Mul(ray1_y, dy));
      const V back0 = hn::MulAdd(hn::LoadU(d, in.ray0_x + i), dx, hn::Mul(hn::LoadU(d, in.ray0_y + i), dy));
      const V back1 = hn::MulAdd(hn::LoadU(d, in.ray1_x + i), dx, hn::Mul(hn::LoadU(d, in.ray1_y + i), dy));
      const auto on0 = hn::And(hn::Gt(hn::Mul(along0, along0), least), hn::Gt(hn::Mul(back1, back1), least));
      const auto on1 = hn::And(hn::Gt(hn::Mul(along1, along1), least), hn::Gt(hn::Mul(back0, back0), least));
      const V contrast = hn::LoadU(d, in.contrast + i);
      auto fits = hn::And(hn::Or(on0, on1), hn::And(hn::Gt(square, nearest), hn::Lt(square, farthest)));
      fits = hn::And(fits, hn::And(hn::Gt(contrast, least_contrast), hn::Lt(contrast, most_contrast)));
      if (hn::AllFalse(d, fits)) continue;

      HWY_ALIGN float squares[kMaxLanes], a0[kMaxLanes], a1[kMaxLanes], b0[kMaxLanes], b1[kMaxLanes];
      std::uint64_t bits = 0;
      hn::StoreMaskBits(d, fits, reinterpret_cast<std::uint8_t*>(&bits));
      const int rest = last - i < lanes ? last - i : lanes;
      bits &= (std::uint64_t{1} << rest) - 1;
      hn::Store(square, d, squares);
      hn::Store(hn::IfThenElseZero(on0, along0), d, a0);
      hn::Store(hn::IfThenElseZero(on1, along1), d, a1);
      hn::Store(back0, d, b0);
      hn::Store(back1, d, b1);
      for (; bits != 0; bits &= bits - 1) {
        const int k = __builtin_ctzll(bits);
        const bool axis = (a1[k] < 0 ? -a1[k] : a1[k]) > (a0[k] < 0 ? -a0[k] : a0[k]);
        const float along = axis ? a1[k] : a0[k], back = axis ? b0[k] : b1[k];
        const int ray = (axis ? 1 : 0) + (along > 0 ? 0 : 2);
        const float distance = __builtin_sqrtf(squares[k]);
        const float cost = distance + search::kOffAxisCost * (distance - (along < 0 ? -along : along));
        if (cost >= best.cost[ray]) continue;
        best.cost[ray] = cost;
        best.corner[ray] = i + k;
        best.ray[ray] = (axis ? 0 : 1) + (back > 0 ? 2 : 0);
      }
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <algorithm>
#include <limits>

#include "detect/corner_search.h"

namespace chequer {
namespace {

HWY_EXPORT(Consider);

/// Cells are empty but for noise: a neighbour is among the nearest corners, or there is none. In clutter, this bounds
/// the work.
constexpr int kMostConsidered = 24;
/// Sides of one cell do not differ that much: no ray is searched farther than so many times the nearest neighbour.
constexpr float kFarthestRatio = 3;
constexpr float kFarthestMore = 16;

}  // namespace

void CornerSearch::Build(int width, int height, std::vector<Corner>& corners) {
  cols_ = (width >> kShift) + 1;
  rows_ = (height >> kShift) + 1;
  start_.assign(static_cast<std::size_t>(cols_ * rows_) + 1, 0);
  const std::size_t count = corners.size();
  bucket_of_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    bucket_of_[i] = Row(corners[i].position.y()) * cols_ + Col(corners[i].position.x());
    ++start_[static_cast<std::size_t>(bucket_of_[i]) + 1];
  }
  for (std::size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
  next_.assign(start_.begin(), start_.end() - 1);
  sorted_.resize(count);
  for (std::size_t i = 0; i < count; ++i)
    sorted_[static_cast<std::size_t>(next_[static_cast<std::size_t>(bucket_of_[i])]++)] = corners[i];
  corners.swap(sorted_);
  // Vectors run over the end: what they read there is not used.
  constexpr std::size_t kBeyond = 64;
  for (std::vector<float>* values : {&x_, &y_, &ray0_x_, &ray0_y_, &ray1_x_, &ray1_y_, &contrast_})
    values->resize(count + kBeyond);
  for (std::size_t i = 0; i < count; ++i) {
    const Corner& corner = corners[i];
    x_[i] = corner.position.x(), y_[i] = corner.position.y();
    ray0_x_[i] = corner.rays[0].x(), ray0_y_[i] = corner.rays[0].y();
    ray1_x_[i] = corner.rays[1].x(), ray1_y_[i] = corner.rays[1].y();
    contrast_[i] = corner.contrast;
  }
}

NearestCorners CornerSearch::Find(int index) const {
  const search::Arrays arrays{x_.data(),      y_.data(),      ray0_x_.data(),  ray0_y_.data(),
                              ray1_x_.data(), ray1_y_.data(), contrast_.data()};
  search::Best best{};
  const std::size_t i = static_cast<std::size_t>(index);
  const int col = Col(x_[i]), row = Row(y_[i]);
  const int reach = static_cast<int>(kLongest) >> kShift;
  for (int ring = 1;; ring = std::min(2 * ring, reach)) {
    std::fill(std::begin(best.cost), std::end(best.cost), std::numeric_limits<float>::infinity());
    std::fill(std::begin(best.corner), std::end(best.corner), -1);
    const int first_col = std::max(col - ring, 0), last_col = std::min(col + ring, cols_ - 1);
    int considered = 0, rows = 0;
    int ranges[2 * (static_cast<int>(kLongest) >> kShift) + 1][2];
    for (int r = std::max(row - ring, 0); r <= std::min(row + ring, rows_ - 1); ++r) {
      const int first = First(r, first_col), last = First(r, last_col + 1);
      if (first == last) continue;
      considered += last - first;
      ranges[rows][0] = first;
      ranges[rows++][1] = last;
    }
    HWY_DYNAMIC_DISPATCH(Consider)(arrays, index, ranges, rows, kLongest, best);
    const float searched = static_cast<float>(ring << kShift);
    const float nearest = *std::min_element(std::begin(best.cost), std::end(best.cost));
    const float farthest = *std::max_element(std::begin(best.cost), std::end(best.cost));
    if (searched >= farthest || searched >= kFarthestRatio * nearest + kFarthestMore || considered > kMostConsidered ||
        ring >= reach)
      break;
  }
  NearestCorners found;
  std::copy(std::begin(best.corner), std::end(best.corner), found.corner.begin());
  std::copy(std::begin(best.ray), std::end(best.ray), found.ray.begin());
  return found;
}

}  // namespace chequer
#endif  // HWY_ONCE
