#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <array>
#include <span>
#include <vector>

#include "detect/board_equations.h"
#include "detect/board_geometry.h"
#include "detect/board_pixels.h"
#include "detect/light.h"
#include "detect/normal_integral.h"
#include "detect/shadow_edge.h"

namespace chequer {

/// What the photometric model leaves out: a corner's pixels also hold light of the cells beyond the four around it, and
/// at the rim of what lies beside the board. That matters where the blur is not small against a cell, from half the
/// distance of three standard deviations on: there the light is computed from the cells' levels, and from the image
/// beside the board, and taken out of the pixels. Ink that has spread moves edges to either side by turns: pixels are
/// moved back with them, so that the model's derivatives are right too, and what that leaves is taken out. Keeps its
/// memory.
class FarCells {
 public:
  /// Whether there is something to take out. @param shadowed the edge of a shadow is fitted too: what the cells beyond
  /// leave in the pixels would be taken for a part of it.
  static bool Matter(const BoardPixels& pixels, double blur_px, bool shadowed);

  /// Begins with pixels that nothing was taken out of but a shadow. @param channel_of_phase 0 … 2 by parity of x + 2 ·
  /// parity of y. @param shadow the same as of the pixels, for what lies beside the board; may be null.
  void Start(const LightReader& reader, const Lens& lens, const BoardGeometry& geometry,
             const std::array<int, 4>& channel_of_phase, const ShadowEdge* shadow, const BoardPixels& pixels);

  /// What is known of a board by now.
  struct Known {
    const BoardGeometry* geometry = nullptr;
    double blur_px = 1;
    /// By how much dark cells grow into light ones on each side, cells.
    double ink_spread = 0;
    /// The way of every point during the exposure, image pixels: the corners' own model has a blur as wide instead.
    Eigen::Vector2d smear_px = Eigen::Vector2d::Zero();
    /// By cell, row by row.
    std::span<const PhaseValues> levels;
    /// They are the quadrants', corner by corner: farther cells then are taken to be as light as those around the
    /// corner.
    bool own_levels = false;
    /// Light from which on pixels stay as they are.
    float saturation = 1;
  };
  /// Takes out what is known by now, instead of what was taken out before.
  void TakeOut(const Known& known, BoardPixels& pixels);
  /// Puts back what was taken out.
  void PutBack(BoardPixels& pixels);
  /// The pixels are as they were before anything was taken out.
  void Forget(const BoardPixels& pixels);
  /// Light that was taken out of a pixel: what it has more than the corners' own model, where the pixel now lies.
  float Of(const LaneBlock& lanes, int lane, int pixel) const {
    return taken_[static_cast<std::size_t>(lane * lanes.capacity() + pixel)].light;
  }
  /// By how much the ink spreads more than is known, by a least squares step of that alone over the pixels as they are:
  /// as TakeOut() left them, or as they were if it was not called. @param used by corner. @param stride every how many
  /// pixels are looked at.
  double MoreInkSpread(const Known& known, std::span<const bool> used, const BoardPixels& pixels, int stride);
  /// By how much the smear is longer than is known, image pixels, by a step of the same kind.
  Eigen::Vector2d MoreSmear(const Known& known, std::span<const bool> used, const BoardPixels& pixels) const;
  /// Whether what is taken out changes so much when the board moves that the corners' own model misjudges moves.
  static bool MoveWithBoard(const Known& known, const BoardPixels& pixels);
  /// Of a board's small moves then, how much those are that the steps by the corners' own model make of them, cells'
  /// levels following; as BoardGeometry has moves, for information about them.
  BoardGeometry::Information ResponseToMoves(const Known& known, std::span<const bool> used, const BoardPixels& pixels);

 private:
  /// The levels, among the light beside the board.
  void SetCells(const Known& known, MarkerSize size);

  /// The cells around a corner, and how its pixels lie among them.
  struct Around {
    Eigen::Matrix3f board_from_plane;
    Eigen::Matrix2f board_by_pixel, plane_by_board;
    Eigen::Vector2f corner;
    float scale_x = 1, scale_y = 1;                   ///< standard deviations of the blur a cell
    float near_scale_x = 1, near_scale_y = 1;         ///< the same of the corners' own model
    Eigen::Vector2f smear = Eigen::Vector2f::Zero();  ///< the way of a point, cells
    int row = 0, col = 0;                             ///< the cell towards −x, −y
    int taps = 1;                                     ///< points of that way that are looked at
    bool falling = false;                             ///< dark are the cells up left and down right
    std::array<std::array<PhaseValues, 4>, 4> light;

    /// Of a pixel, cells from the corner.
    Eigen::Vector2f From(float u, float v) const;
  };
  /// What was done to a pixel: light that was taken out, and the move of its plane coordinates.
  struct Taken {
    float light = 0, u = 0, v = 0;
  };
  static bool ReachAcross(double share, const BoardPixels& pixels, double blur_px);
  Around AroundCorner(const Known& known, const BoardPixels& pixels, int corner) const;
  /// Calls visit(around, phase, from, light) for every stride-th pixel of a lane, of the corners that are used; not for
  /// saturated ones.
  template <class Visit>
  void ForPixels(const Known& known, std::span<const bool> used, const BoardPixels& pixels, int stride,
                 const Visit& visit) const;
  /// Of a pixel that lies there, cells from the corner: what the model leaves out, and what it has.
  float Far(const Around& around, int phase, const Eigen::Vector2f& from, float spread) const;
  /// The same where the image is smeared: the mean of what the points of the way show, less the corner's own model.
  float FarOfSmeared(const Around& around, int phase, const Eigen::Vector2f& from) const;
  struct PixelDerivatives;
  /// Of the light of 4 × 4 cells around, row by row.
  using CellShares = std::array<float, 16>;
  CellShares SharesOfSmeared(const Around& around, const Eigen::Vector2f& from, const Eigen::Vector2f& smear) const;
  CellShares SharesOfModel(const Around& around, const Eigen::Vector2f& from) const;
  float Smeared(const Around& around, int phase, const Eigen::Vector2f& from, const Eigen::Vector2f& smear) const;
  float NearOfSmeared(const Around& around, int phase, const Eigen::Vector2f& from) const;
  float Near(const Around& around, int phase, const Eigen::Vector2f& from, float spread) const;
  /// Of the normal distribution.
  float Integral(float deviations) const { return (*table_)(deviations); }
  /// Where a pixel would lie if the edges beside it had not spread.
  Eigen::Vector2f Unspread(const Around& around, const Eigen::Vector2f& from, float spread) const;

  /// Scratch of ResponseToMoves, whose memory is kept.
  struct Moves {
    using Geometry = Eigen::Matrix<double, Eigen::Dynamic, BoardGeometry::kParameters>;
    Eigen::MatrixXd own, both;
    Eigen::LLT<Eigen::MatrixXd> own_factor;
    Eigen::PartialPivLU<Eigen::MatrixXd> both_factor;
    Geometry geometry, of_own, answer, product;
  };

  const NormalTable* table_ = &NormalTable::Get();
  Moves moves_;
  std::array<int, 4> channel_of_phase_{};
  std::vector<PhaseValues> cells_;   ///< with a ring of what lies beside the board
  std::vector<PhaseValues> beside_;  ///< the same; only the ring is told
  std::vector<Taken> taken_;         ///< by lane and pixel
};

}  // namespace chequer
