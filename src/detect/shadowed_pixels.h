#pragma once

#include <array>
#include <span>
#include <vector>

#include "detect/board_equations.h"
#include "detect/board_pixels.h"
#include "detect/far_cells.h"
#include "detect/noise_model.h"
#include "detect/shadow_edge.h"

namespace chequer {

/// The pixels of a board as they were before the shadow was taken out of them, by which its edge is fitted in turns
/// with the board. Keeps its memory.
class ShadowedPixels {
 public:
  /// What is known of a board by now.
  struct Known {
    const BoardGeometry* geometry = nullptr;
    double blur_px = 1;
    /// By cell, row by row, in the light beside the shadow.
    std::span<const PhaseValues> levels;
    const NoiseModel* noise = nullptr;
    /// Has taken light out of the pixels, too; may be null.
    const FarCells* far_cells = nullptr;
    std::array<int, 4> channel_of_phase{};
    /// Light from which on pixels tell nothing.
    float saturation = 1;
  };

  /// Keeps the pixels as they are. @param edge roughly: what the pixels do not tell stays as it is there.
  void Start(const ShadowEdge& edge, const BoardPixels& pixels);
  void PutBack(BoardPixels& pixels) const;
  /// A step of least squares of the edge alone, the cells' levels following. @pre `edge` was taken out of the pixels.
  /// @param used by corner. Returns whether it may have to move again. 0.03 µs a pixel.
  bool Move(const Known& known, std::span<const bool> used, const BoardPixels& pixels, ShadowEdge& edge);

 private:
  struct Pixel {
    float u, v, light;
  };

  std::vector<Pixel> pixels_;  ///< corner by corner, lane by lane
  ShadowEdge::Parameters start_ = ShadowEdge::Parameters::Zero();
};

}  // namespace chequer
