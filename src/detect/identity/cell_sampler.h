#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "detect/common/cell_unmixer.h"
#include "detect/common/light.h"
#include "detect/common/scratch.h"
#include "detect/fit/fit.h"

namespace chequer {

/// The light of a board's cells, row by row.
struct CellLights {
  std::vector<Eigen::Vector3f> light;
  std::vector<float> half_lit;  ///< which share of the light that a dark cell was assumed to get may have reached it
  std::vector<std::uint8_t> overexposed;  ///< a channel is at full scale: there may have been more light
  std::size_t mixed_pixels = 0;           ///< of cells that had to be solved for together
};

/// A board in an image.
struct BoardInImage {
  const FittedBoard& board;
  MarkerSize size;
  const LightReader& reader;
  const Lens& lens;
};

/// How much the light differs between the four quarters of a cell's inside: largest minus smallest, by channel. Blur
/// from the cell's edges adds about the same to each quarter.
Eigen::Vector3f LightDiffers(const BoardInImage& in, std::size_t cell);

/// Measures the light of each cell of a fitted board: by the fit's own levels where it saw all channels, else in the
/// middles of the cells, or of all cells together where these are too small for that.
class CellSampler {
 public:
  void Sample(const BoardInImage& in, CellLights& cells);

 private:
  /// Where windows within the cells would be too small: solves for all of them at once. False where that fails.
  bool SampleSmall(const BoardInImage& in, CellLights& cells);
  /// The level of an overexposed cell is known by the mixed pixels at its edges alone, and takes those of its
  /// neighbours with it: where there is one, reads the cells' middles instead. White stays white there, and yellow is
  /// short of blue.
  void SampleOverexposed(const BoardInImage& in, CellLights& cells);

  /// What is known of one board.
  struct Board {
    std::vector<Eigen::Vector3f> middles, unmixed;
  };

  Scratch<Board> board_;
  CellUnmixer unmixer_;  ///< keeps only memory from one board to the next
};

}  // namespace chequer
