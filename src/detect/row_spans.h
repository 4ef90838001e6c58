#pragma once

#include <array>

namespace chequer {

/// The plane coordinates of the pixels around one, to second order.
struct LocalPlane {
  /// Of u and v: the value, the slopes by x and y, ½ d²/dx², d²/dxdy, ½ d²/dy².
  std::array<float, 2> at, by_x, by_y, by_xx, by_xy, by_yy;
};

/// A band of the board between two lines of constant x or y, cut along rows of pixels: offsets along the row from a
/// point, which move by `slope` a row.
struct Band {
  float low, high, slope;
};

/// A part of the image around a point: where two bands cross. Whole pixels are counted from one near the point.
struct CrossedBands {
  std::array<Band, 2> bands;
  float point_x = 0, point_y = 0;  ///< of the point, from that pixel
  float left = 0, right = 0;       ///< first and last column that there is
  LocalPlane plane;                ///< around the point
};

/// The pixels of some rows within it.
struct RowSpans {
  static constexpr int kRows = 16;
  alignas(64) int first[kRows];   ///< column
  alignas(64) int pixels[kRows];  ///< may be below 1: none
  /// Plane coordinates of the first, and how far on the second lies.
  alignas(64) float u[kRows], v[kRows], step_u[kRows], step_v[kRows];
};

/// Fills in the rows from `row` on.
void FindRowSpans(const CrossedBands& region, int row, RowSpans& spans);

}  // namespace chequer
