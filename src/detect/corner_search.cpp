#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/corner_search.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstdint>

#ifndef CHEQUER_DETECT_CORNER_SEARCH
#define CHEQUER_DETECT_CORNER_SEARCH
namespace chequer {
namespace search {

/// The corners' arrays, readable up to a vector beyond their ends.
struct Arrays {
  const float *x, *y, *ray0_x, *ray0_y, *ray1_x, *ray1_y, *contrast, *handicap;
};

/// The best so far, by ray.
struct Best {
  float cost[4];
  int corner[4];
};

constexpr float kInfinity = 1e30f;
/// Corners that are looked at together: rows of a window are short, and longer vectors would be empty for the most
/// part.
constexpr int kPiece = 8;

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

/// Looks from the corner `from` at the corners of some pieces, of search::kPiece at most before the one past the last
/// of each, for better ones than the best so far. Nothing branches on what the corners are like: in clutter, it would
/// be guessed wrong as often as not.
void Consider(const search::Arrays& in, int from, const std::array<int, 2>* pieces, std::size_t count, float longest,
              search::Best& best) {
  const hn::CappedTag<float, search::kPiece> d;
  const hn::RebindToSigned<decltype(d)> di;
  using V = hn::Vec<decltype(d)>;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V x = hn::Set(d, in.x[from]), y = hn::Set(d, in.y[from]);
  const V ray0_x = hn::Set(d, in.ray0_x[from]), ray0_y = hn::Set(d, in.ray0_y[from]);
  const V ray1_x = hn::Set(d, in.ray1_x[from]), ray1_y = hn::Set(d, in.ray1_y[from]);
  const V least_contrast = hn::Set(d, in.contrast[from] / search::kMostContrastRatio);
  const V most_contrast = hn::Set(d, in.contrast[from] * search::kMostContrastRatio);
  const V nearest = hn::Set(d, search::kShortest * search::kShortest), farthest = hn::Set(d, longest * longest);
  const V cosine = hn::Set(d, search::kLeastSquaredCosine), off_axis = hn::Set(d, search::kOffAxisCost);
  const V zero = hn::Zero(d);
  // The best of each vector lane, by ray; one of them is the best of all.
  V cost0 = hn::Set(d, best.cost[0]), cost1 = hn::Set(d, best.cost[1]);
  V cost2 = hn::Set(d, best.cost[2]), cost3 = hn::Set(d, best.cost[3]);
  auto index0 = hn::Set(di, best.corner[0]), index1 = hn::Set(di, best.corner[1]);
  auto index2 = hn::Set(di, best.corner[2]), index3 = hn::Set(di, best.corner[3]);
  for (std::size_t piece = 0; piece < count; ++piece)
    for (int offset = 0; offset < search::kPiece; offset += lanes) {
      const int i = pieces[piece][0] + offset, left = std::max(pieces[piece][1] - i, 0);
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
      fits = hn::And(fits, hn::FirstN(d, static_cast<std::size_t>(left)));
      if (hn::AllFalse(d, fits)) continue;

      const V a0 = hn::IfThenElseZero(on0, hn::Abs(along0)), a1 = hn::IfThenElseZero(on1, hn::Abs(along1));
      const auto second = hn::Gt(a1, a0);
      const V along = hn::IfThenElse(second, along1, along0);
      const V distance = hn::Sqrt(square);
      const V cost =
          hn::Mul(hn::LoadU(d, in.handicap + i), hn::MulAdd(off_axis, hn::Sub(distance, hn::Abs(along)), distance));
      const auto forward = hn::And(fits, hn::Gt(along, zero)), backward = hn::AndNot(hn::Gt(along, zero), fits);
      const auto index = hn::Iota(di, i);
      const auto keep = [&](auto on_ray, V& best_cost, auto& best_index) HWY_ATTR {
        const auto better = hn::And(on_ray, hn::Lt(cost, best_cost));
        best_cost = hn::IfThenElse(better, cost, best_cost);
        best_index = hn::IfThenElse(hn::RebindMask(di, better), index, best_index);
      };
      keep(hn::AndNot(second, forward), cost0, index0);
      keep(hn::And(second, forward), cost1, index1);
      keep(hn::AndNot(second, backward), cost2, index2);
      keep(hn::And(second, backward), cost3, index3);
    }
  const auto reduce = [&](V cost, auto index, int ray) HWY_ATTR {
    const V least_cost = hn::MinOfLanes(d, cost);
    best.cost[ray] = hn::GetLane(least_cost);
    best.corner[ray] = hn::ExtractLane(index, static_cast<std::size_t>(hn::FindFirstTrue(d, hn::Eq(cost, least_cost))));
  };
  reduce(cost0, index0, 0);
  reduce(cost1, index1, 1);
  reduce(cost2, index2, 2);
  reduce(cost3, index3, 3);
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <algorithm>
#include <cstdlib>

#include "detect/corner_search.h"

namespace chequer {
namespace {

HWY_EXPORT(Consider);

/// Cells are empty but for noise: a neighbour is among the nearest corners, or there is none. In clutter, this bounds
/// the work.
constexpr int kMostConsidered = 24;
/// Fewer corners are hardly ever enough: they are looked at together with those around them.
constexpr int kEnoughAtOnce = 16;
/// No ray is searched farther than so many times the nearest neighbour, as long as only one direction of the lattice
/// has one: seen at a slant, cells are that much longer than wide.
constexpr float kFarthestRatio = 3;
constexpr float kFarthestMore = 16;
/// With one in both directions, the opposite ones lie hardly farther.
constexpr float kOppositeRatio = 1.5f;
constexpr float kOppositeMore = 3;
/// How much farther corners on ridges count: inside narrow cells they lie nearer to a corner than its neighbour.
constexpr float kRidgeHandicap = 3;

/// How far there can be neighbours that matter.
float Sufficient(const search::Best& best) {
  const float* cost = best.cost;
  const float farthest = *std::max_element(cost, cost + 4);
  const float even = std::min(cost[0], cost[2]), odd = std::min(cost[1], cost[3]);
  if (even < search::kInfinity && odd < search::kInfinity)
    return std::min(farthest, kOppositeRatio * std::max(even, odd) + kOppositeMore);
  return std::min(farthest, kFarthestRatio * std::min(even, odd) + kFarthestMore);
}

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
  for (std::vector<float>* values : {&x_, &y_, &ray0_x_, &ray0_y_, &ray1_x_, &ray1_y_, &contrast_, &handicap_})
    values->resize(count + kBeyond);
  for (std::size_t i = 0; i < count; ++i) {
    const Corner& corner = corners[i];
    x_[i] = corner.position.x(), y_[i] = corner.position.y();
    ray0_x_[i] = corner.rays[0].x(), ray0_y_[i] = corner.rays[0].y();
    ray1_x_[i] = corner.rays[1].x(), ray1_y_[i] = corner.rays[1].y();
    contrast_[i] = corner.contrast;
    handicap_[i] = corner.ridge ? kRidgeHandicap : 1.0f;
  }
}

float CornerSearch::Covered(float x, float y, int row, int col, int ring) const {
  // From the point to the nearest side of the buckets around its own; the image's border hides nothing.
  const float size = static_cast<float>(1 << kShift);
  const auto to_side = [&](float at, int bucket, int buckets) {
    const float before = bucket - ring <= 0 ? 1e9f : at - static_cast<float>(bucket - ring) * size;
    const float after = bucket + ring >= buckets - 1 ? 1e9f : static_cast<float>(bucket + ring + 1) * size - at;
    return std::min(before, after);
  };
  return std::min(to_side(x, col, cols_), to_side(y, row, rows_));
}

void CornerSearch::WindowAround(int row, int col, int ring, Window& window) const {
  const int first_col = std::max(col - ring, 0), past_col = std::min(col + ring, cols_ - 1) + 1;
  window.corners = 0;
  std::size_t count = 0;
  for (int r = std::max(row - ring, 0); r <= std::min(row + ring, rows_ - 1); ++r) {
    const int first = First(r, first_col), past = First(r, past_col), length = past - first;
    window.corners += length;
    // Nearly every row has two pieces at most: then nothing branches on how many, which would be guessed wrong.
    const std::size_t pieces = static_cast<std::size_t>((length + search::kPiece - 1) / search::kPiece);
    if (window.pieces.size() < count + pieces + 2) window.pieces.resize(count + pieces + 2);
    window.pieces[count] = {first, past};
    window.pieces[count + 1] = {first + search::kPiece, past};
    for (std::size_t k = 2; k < pieces; ++k)
      window.pieces[count + k] = {first + static_cast<int>(k) * search::kPiece, past};
    count += pieces;
  }
  window.count = count;
  window.ring = ring;
}

void CornerSearch::TakeFirstWindow(int row, int col) {
  int ring = 1;
  WindowAround(row, col, ring, first_);
  while (first_.corners < kEnoughAtOnce && ring < kReach) {
    ring = std::min(2 * ring, kReach);
    WindowAround(row, col, ring, first_);
  }
}

NearestCorners CornerSearch::Find(int index, int row, int col) {
  const search::Arrays arrays{x_.data(),      y_.data(),      ray0_x_.data(),   ray0_y_.data(),
                              ray1_x_.data(), ray1_y_.data(), contrast_.data(), handicap_.data()};
  search::Best best;
  std::fill_n(best.cost, 4, search::kInfinity);
  std::fill_n(best.corner, 4, -1);
  const std::size_t i = static_cast<std::size_t>(index);
  HWY_DYNAMIC_DISPATCH(Consider)(arrays, index, first_.pieces.data(), first_.count, kLongest, best);
  // Wider windows look at the corners of the narrower ones again: their rows are few and short.
  const Window* window = &first_;
  while (window->corners <= kMostConsidered && window->ring < kReach &&
         Covered(x_[i], y_[i], row, col, window->ring) < Sufficient(best)) {
    const int corners = window->corners;
    WindowAround(row, col, std::min(2 * window->ring, kReach), wider_);
    window = &wider_;
    if (wider_.corners > corners)
      HWY_DYNAMIC_DISPATCH(Consider)(arrays, index, wider_.pieces.data(), wider_.count, kLongest, best);
  }
  NearestCorners found;
  for (std::size_t ray = 0; ray < 4; ++ray) {
    found.corner[ray] = best.corner[ray];
    // Of its rays of the other kind, the one that points back. Of none, any.
    const std::size_t j = static_cast<std::size_t>(std::max(best.corner[ray], 0));
    const bool even = ray % 2 == 1;
    const float away =
        (even ? ray0_x_[j] : ray1_x_[j]) * (x_[j] - x_[i]) + (even ? ray0_y_[j] : ray1_y_[j]) * (y_[j] - y_[i]);
    found.ray[ray] = static_cast<std::uint8_t>((even ? 0 : 1) + (away > 0 ? 2 : 0));
  }
  return found;
}

}  // namespace chequer
#endif  // HWY_ONCE
