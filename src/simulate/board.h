#pragma once

#include <cstdint>
#include <string>

#include "chequer/marker.h"

namespace chequer {

/// What is printed: a grid of coloured cells. Cells 'K', 'W', 'B', 'Y' row by row from the top left, as seen upright.
struct Board {
  int rows = 0;
  int cols = 0;
  std::string cells;
  /// Cells of `rows` and `cols` that the stated side does not count, on each side (AprilTag's white rim).
  int uncounted_rim = 0;

  // For the truth: whose it is.
  std::uint64_t id = 0;
  std::string variant;  ///< VariantName, "tag36h11" or "aruco4x4_1000"

  /// Metres of a cell's edge when the longer counted side is side_m.
  double CellSize(double side_m) const;
  /// Whether dark and light cells alternate, beginning with dark, as on every colour checkerboard.
  bool Alternates() const;
};

/// The board of an id. @pre id ≤ code.max_id().
Board MakeBoard(const MarkerCode& code, std::uint64_t id);

/// Whether the peers' families can be drawn (their libraries were there when this was built).
bool HasAprilTag();
bool HasAruco();

/// AprilTag 36h11 with its white rim of one cell; its side is that of the black square, 8 of 10 cells.
/// Throws std::runtime_error where the id is not in the family or the library is missing.
Board AprilTag36h11(std::uint64_t id);

/// ArUco's DICT_4X4_1000 with a white rim of one cell; its side is that of the black square, 6 of 8 cells.
/// Throws std::runtime_error where the id is not in the dictionary or the library is missing.
Board Aruco4x4(std::uint64_t id);

}  // namespace chequer
