#pragma once

#include <array>
#include <cstdint>

#include "detect/common/light.h"
#include "detect/fit/photometric_kernel.h"

namespace chequer {

/// The plane coordinates of the pixels around a point, from an origin, to second order.
struct LocalPlane {
  /// Of u and v: the value, the slopes by x and y, ½ d²/dx², d²/dxdy, ½ d²/dy².
  std::array<float, 2> at{}, by_x{}, by_y{}, by_xx{}, by_xy{}, by_yy{};
};

/// A band of the board between two lines of constant x or y, cut along rows of pixels: offsets along the row from the
/// corner, which move by `slope` a row.
struct Band {
  float low, high, slope;
};

/// Which pixels of large cells are left out: whole 2 × 2 tiles, so that all parities stay balanced.
struct Thinning {
  /// A share of the tiles. Of a larger one are those of a smaller one, and few others where it is but a little larger.
  using Share = std::uint32_t;
  static constexpr Share kAll = ~Share{0};
  static Share ShareOf(double share) { return share < 1 ? static_cast<Share>(share * kAll) : kAll; }

  bool all = true;                         ///< nothing is left out
  Share near_edges = kAll, inside = kAll;  ///< of the tiles that are kept
  float band_x = 0, band_y = 0;            ///< near an edge, cells
};

/// The part of a board whose pixels are a corner's.
struct CornerPart {
  int x = 0, y = 0;                  ///< a pixel beside the corner
  float corner_x = 0, corner_y = 0;  ///< the corner from there
  int first_row = 0, rows = 0;       ///< counted from y; all in the image
  std::array<Band, 2> bands{};       ///< that cross in it
  LocalPlane plane{};                ///< around the corner
  Thinning thinning{};
  std::array<float, 2> board_by_x{}, board_by_y{};  ///< cells a pixel, for the thinning
};

/// Puts the pixels of a part into the four lanes of a block from `lane` on, by phase, and sets their counts. Lanes that
/// are full take no more. Returns how many pixels. 6 ns a row and 1.5 ns a pixel. @param width of the image.
int TakePixels(const CornerPart& part, const LightReader::Rows& rows, int width, int lane, LaneBlock& block);

}  // namespace chequer
