#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "detect/common/board_geometry.h"
#include "detect/common/visibility.h"
#include "detect/fit/blur_shape.h"
#include "detect/fit/edge_spread.h"
#include "detect/fit/edge_tally.h"
#include "detect/fit/fit_choice.h"
#include "detect/fit/ink_register.h"
#include "detect/fit/linear_bend.h"
#include "detect/fit/noise_model.h"

namespace chequer {

/// What boards of an image have in common: what one has shown the next need not find out.
struct ImageTraits {
  NoiseModel noise;
  double blur_px = 1;
  EdgeSpread edges;
  /// How far the board moved during the exposure, image pixels; zero if that was not fitted.
  Eigen::Vector2d motion_px = Eigen::Vector2d::Zero();
  /// Dot gain, cells; 0 if there is none.
  double dot_gain = 0;
  /// The board was asked for another shape of its edges than a Gaussian's, and has none.
  bool gaussian_edges = false;

  /// Whether there is nothing that the next image of the stream need ask for, but the noise.
  bool AreSimple() const { return gaussian_edges && dot_gain == 0; }
};

/// The light that falls on a cell, over that of the board (its mean; beside the shadow, where its edge was fitted):
/// by the corners around the cell; zeros where none tells.
struct CellLight {
  float least = 0, most = 0;

  /// By the edge of a shadow.
  bool crossed() const { return most > 1.25f * least; }
};

/// Mean levels of an overexposed board's light cells, white and yellow, by channel; zeros of other boards. Above full
/// scale, edges alone tell them: a fit that begins at full scale takes several steps to them.
struct LightLevels {
  /// Mean light of a cell of which much is saturated.
  static constexpr float kOverexposed = 0.98f;

  std::array<Eigen::Vector3f, 2> of_ink{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};

  bool known() const { return std::max(of_ink[0].maxCoeff(), of_ink[1].maxCoeff()) > 0; }
};

/// A board after the joint photometric fit.
struct FittedBoard {
  /// Fewer corners do not determine a board with something to spare.
  static constexpr int kFewestCorners = 6;

  BoardGeometry geometry;
  /// Inverse covariance of the geometry's parameters, from all pixels, with the levels, the blur and the noise as
  /// measured in this board, widened by how much its corners disagree with the geometry beyond that noise.
  BoardGeometry::Information information = BoardGeometry::Information::Zero();
  /// By which the geometry's parameters may be off, the same in every frame, as the blue ink's place is known only by
  /// the corners and Start::register_cells; zeros where that was not given.
  RegisterColumns by_register = RegisterColumns::Zero();
  ImageTraits image;
  /// As the blur tells it, or a term.
  BlurShape motion;
  /// Of the blur, where the board did not move so far that image.motion_px was fitted.
  BlurShape blur_shape;
  /// How far it lies from where the fit began, square of standard deviations; infinite after others than plain fits.
  double moved_square = std::numeric_limits<double>::infinity();
  SharedEdgeErrors along_edges;
  /// Without corners, too, where the bend was found and the geometry is that of the board's middle.
  BendEvidence bend;
  /// Contrast of the board, light, over the standard deviation of a pixel that the model does not explain.
  double signal_to_noise = 0;
  Explained explained;
  /// Light of each cell, row by row, by channel; the other channels are zero.
  std::vector<Eigen::Vector3f> levels;
  /// By cell, where shadows' edges cross the board; else empty. The levels are free of it.
  std::vector<CellLight> lit;
  /// Corners that show tell the pose, cells that show have a corner that tells their levels.
  Visibility visibility;
  double reprojection_rms_px = 0;
  /// Something may lie over cells that count: corners that are used disagree with the others as occluded ones do, or a
  /// cell's corners were all pulled. (Measured: with nothing more asked of such boards, three of 17,000 with covers had
  /// wrong ids, which lead by 7 to 10.)
  bool doubtful = false;

  int corners_used() const { return visibility.CountCorners(); }
  bool determined() const { return corners_used() >= kFewestCorners && information.allFinite(); }
  /// Whether its corners lie where a flat board's do, printed as it should be.
  bool flat() const { return reprojection_rms_px <= 0.06; }
};

}  // namespace chequer
