#include "detect/affine_view.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace chequer {
namespace {

/// Bits behind the point of coordinates.
constexpr int kBits = 16;
/// Between the samples that make up a pixel, px of the plane.
constexpr float kTapPx = 1.5f;

/// A point or a step in the plane, in fixed point.
struct FixedPoint {
  explicit FixedPoint(const Eigen::Vector2f& p)
      : x(static_cast<int>(std::lround(p.x() * (1 << kBits)))),
        y(static_cast<int>(std::lround(p.y() * (1 << kBits)))) {}
  void operator+=(const FixedPoint& step) { x += step.x, y += step.y; }

  int x, y;
};

/// Between the four pixels around a point. @tparam kInside the point is known to have four.
template <bool kInside>
int SampleAt(const BytePlane& plane, int x, int y) {
  if constexpr (!kInside) {
    x = std::clamp(x, 0, ((plane.width() - 1) << kBits) - 1);
    y = std::clamp(y, 0, ((plane.height() - 1) << kBits) - 1);
  }
  const int part_x = x >> (kBits - 8) & 255, part_y = y >> (kBits - 8) & 255;
  const std::uint8_t *above = plane.row(y >> kBits) + (x >> kBits), *below = above + plane.stride();
  const int top = (above[0] << 8) + part_x * (above[1] - above[0]),
            bottom = (below[0] << 8) + part_x * (below[1] - below[0]);
  return (top << 8) + part_y * (bottom - top);
}

void SmoothRow(std::uint8_t* row, int count, int width, std::vector<int>& sums) {
  const int reach = width / 2;
  sums[0] = 0;
  for (int i = 0; i < count + width - 1; ++i)
    sums[static_cast<std::size_t>(i) + 1] =
        sums[static_cast<std::size_t>(i)] + row[std::clamp(i - reach, 0, count - 1)];
  for (int i = 0; i < count; ++i)
    row[i] = static_cast<std::uint8_t>(
        (sums[static_cast<std::size_t>(i + width)] - sums[static_cast<std::size_t>(i)] + reach) / width);
}

/// A row of a view: the means of `taps` samples each, from the first sample on.
template <bool kInside>
void ViewRow(const BytePlane& plane, FixedPoint at, const FixedPoint& right, const FixedPoint& tap_step, int taps,
             std::span<std::uint8_t> row) {
  const int scale = (1 << 16) / taps;
  for (std::uint8_t& pixel : row) {
    FixedPoint sample = at;
    int sum = 0;
    for (int i = 0; i < taps; ++i, sample += tap_step) sum += SampleAt<kInside>(plane, sample.x, sample.y) >> 8;
    pixel = static_cast<std::uint8_t>((static_cast<unsigned>(sum) * static_cast<unsigned>(scale) + (1u << 23)) >> 24);
    at += right;
  }
}

}  // namespace

void ViewPlane(const BytePlane& plane, const Eigen::Vector2f& middle, const Eigen::Matrix2f& plane_by_view, int side,
               BytePlane& view) {
  view.Resize(side, side);
  // Between pixels, a tap takes in two of them.
  const int taps = std::clamp(static_cast<int>(std::lround(plane_by_view.col(0).norm() / kTapPx)), 1, 8);
  // The first of a pixel's taps, one pixel's step to the right, and the step from tap to tap.
  const Eigen::Vector2f tap = plane_by_view.col(0) / static_cast<float>(taps);
  const float half = 0.5f * static_cast<float>(side - 1);
  const FixedPoint right(plane_by_view.col(0)), tap_step(tap);
  // All taps lie between the view's corners and half a pixel's step beyond; the last pixel is for rounding.
  const Eigen::Vector2f reach = half * (plane_by_view.col(0).cwiseAbs() + plane_by_view.col(1).cwiseAbs()) +
                                0.5f * plane_by_view.col(0).cwiseAbs();
  const bool inside = (middle - reach).minCoeff() > 1 && (middle + reach).x() < static_cast<float>(plane.width() - 2) &&
                      (middle + reach).y() < static_cast<float>(plane.height() - 2);
  for (int y = 0; y < side; ++y) {
    const FixedPoint first(middle + plane_by_view * Eigen::Vector2f(-half, static_cast<float>(y) - half) -
                           0.5f * static_cast<float>(taps - 1) * tap);
    const std::span<std::uint8_t> row(view.row(y), static_cast<std::size_t>(side));
    if (inside)
      ViewRow<true>(plane, first, right, tap_step, taps, row);
    else
      ViewRow<false>(plane, first, right, tap_step, taps, row);
  }
}

void SmoothRows(int width, BytePlane& plane, std::vector<int>& sums) {
  sums.resize(static_cast<std::size_t>(plane.width() + width));
  for (int y = 0; y < plane.height(); ++y)
    for (int pass = 0; pass < 2; ++pass) SmoothRow(plane.row(y), plane.width(), width, sums);
}

}  // namespace chequer
