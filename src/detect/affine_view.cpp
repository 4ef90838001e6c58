#include "detect/affine_view.h"

#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// Bits behind the point of coordinates.
constexpr int kBits = 16;

/// A point or a step in the plane, in fixed point.
struct FixedPoint {
  explicit FixedPoint(const Eigen::Vector2f& p)
      : x(static_cast<int>(std::lround(p.x() * (1 << kBits)))),
        y(static_cast<int>(std::lround(p.y() * (1 << kBits)))) {}
  void operator+=(const FixedPoint& step) { x += step.x, y += step.y; }

  int x, y;
};

/// Between the four pixels around a point.
int SampleAt(const BytePlane& plane, int x, int y) {
  x = std::clamp(x, 0, ((plane.width() - 1) << kBits) - 1);
  y = std::clamp(y, 0, ((plane.height() - 1) << kBits) - 1);
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

}  // namespace

void ViewPlane(const BytePlane& plane, const Eigen::Vector2f& middle, const Eigen::Matrix2f& plane_by_view, int side,
               BytePlane& view) {
  view.Resize(side, side);
  const int taps = std::clamp(static_cast<int>(std::lround(plane_by_view.col(0).norm())), 1, 8);
  // The first of a pixel's taps, one pixel's step to the right, and the step from tap to tap.
  const Eigen::Vector2f tap = plane_by_view.col(0) / static_cast<float>(taps);
  const float half = 0.5f * static_cast<float>(side - 1);
  const FixedPoint right(plane_by_view.col(0)), tap_step(tap);
  for (int y = 0; y < side; ++y) {
    FixedPoint at(middle + plane_by_view * Eigen::Vector2f(-half, static_cast<float>(y) - half) -
                  0.5f * static_cast<float>(taps - 1) * tap);
    std::uint8_t* row = view.row(y);
    for (int x = 0; x < side; ++x, at += right) {
      FixedPoint sample = at;
      int sum = 0;
      for (int i = 0; i < taps; ++i, sample += tap_step) sum += SampleAt(plane, sample.x, sample.y);
      row[x] = static_cast<std::uint8_t>((sum / taps + (1 << 15)) >> 16);
    }
  }
}

void SmoothRows(int width, BytePlane& plane, std::vector<int>& sums) {
  sums.resize(static_cast<std::size_t>(plane.width() + width));
  for (int y = 0; y < plane.height(); ++y)
    for (int pass = 0; pass < 2; ++pass) SmoothRow(plane.row(y), plane.width(), width, sums);
}

}  // namespace chequer
