#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "detect/board_equations.h"
#include "detect/board_geometry.h"
#include "detect/board_pixels.h"
#include "detect/edge_shape.h"
#include "detect/far_cells.h"
#include "detect/light.h"
#include "detect/noise_model.h"
#include "detect/shading.h"

namespace chequer {

/// What boards of an image have in common: what one has shown the next need not find out.
struct ImageTraits {
  NoiseModel noise;
  double blur_px = 1;
  EdgeShape edges;
};

/// The light that falls on a cell, over the board's mean, by the corners around it; zeros where none tells.
struct CellLight {
  float least = 0, most = 0;

  /// By the edge of a shadow.
  bool crossed() const { return most > 1.25f * least; }
};

/// A board after the joint photometric fit.
struct FittedBoard {
  BoardGeometry geometry;
  /// Inverse covariance of the geometry's parameters, from all pixels, with the levels, the blur and the noise as
  /// measured in this board, widened by how much its corners disagree with the geometry beyond that noise.
  BoardGeometry::Information information;
  ImageTraits image;
  /// Contrast of the board, light, over the standard deviation of a pixel that the model does not explain.
  double signal_to_noise = 0;
  /// Light of each cell, row by row, by channel; the other channels are zero.
  std::vector<Eigen::Vector3f> levels;
  /// By cell, where shadows' edges cross the board; else empty. The levels are free of it.
  std::vector<CellLight> lit;
  int corners_used = 0;
  std::array<bool, kMaxCorners> corner_used{};
  double reprojection_rms_px = 0;
};

/// Fits geometry, cell levels (free for every cell and channel), blur and noise of one board to its pixels, by
/// Gauss-Newton on the model of photometric_kernel.h (detection.md 3.4 gives the derivation; Krüger and Yang have the
/// corner-wise model). Keeps its memory.
/// Gives up where a corner moves by more than 3 px in a step, but in the first one only if those that were found do; a
/// result's last step moved no corner by more than 0.05 px, so that what is left is of second order, or was the eighth.
/// The pose that it leads to is near the Cramér–Rao bound, 0.0025 px for the centre of a board of 8 px cells:
/// side_by_side prints how near, case by case. What no model of a plane knows (bent paper, what is left of the lens)
/// widens the information instead. 24 µs a board of 7.8 px cells, growing with its pixels.
/// Where the light is bent, or cells are small against the blur, the pixels' light is corrected between the steps
/// (shading.h, far_cells.h): up to 0.5 ms; where ink has spread, so are their places: 2 to 10 ms.
/// Where corners turn out to be hidden, or the edge of a shadow crosses the board, it is fitted anew without them, or
/// with levels for each corner's quadrants: two to six times the time.
class PhotometricFit {
 public:
  struct Start {
    MarkerSize size;
    BoardGeometry geometry;
    double blur_px = 0.8;
    /// Light (R, G, B) and saturation of each cell as far as known before the fit, row by row.
    std::span<const Eigen::Vector3f> light;
    std::span<const std::uint8_t> saturated;
    /// Cells that do not show: corners with two of them are left out.
    std::span<const std::uint8_t> covered;
    /// Corners that were found; the geometry may have others pixels off.
    std::array<bool, kMaxCorners> found{};
    /// Of another board of the same image, if one was fitted before: saves a pass, and most of the first step.
    const ImageTraits* image = nullptr;
    /// It was found where the image is smeared; or, if it seems blurred, that may be tried: about 20 ms where it is so.
    bool smeared = false, may_be_smeared = false;
  };

  /// Nothing if the board lies outside the image for the most part, does not look like the model, or the fit runs away.
  /// The result is valid until the next call.
  const FittedBoard* Fit(const LightReader& reader, const Lens& lens, const Start& start);

 private:
  const FittedBoard* FitAsItIs(const LightReader& reader, const Lens& lens, const Start& start);
  /// By the corners that are neither covered nor left out.
  bool FitUsable(const LightReader& reader, const Lens& lens, const Start& start);
  /// The same from where the result has the board.
  bool FitAnew(const LightReader& reader, const Lens& lens, const Start& start);
  /// What hides corners has told the light, the levels and the noise before it was known to: fits anew without them.
  void LeaveOutHidden(const LightReader& reader, const Lens& lens, const Start& start);
  /// Of the corners that were found hidden, those that fit worst. False if none was.
  bool LeaveOutWorstHidden();
  /// What covers a whole side may pull the board until all corners are off, and none so much more than the others that
  /// it is found hidden. Whether it was so.
  bool LeaveOutSide(const LightReader& reader, const Lens& lens, const Start& start);
  /// The corners of the side that fits worst, if it fits much worse than the opposite one.
  std::optional<std::array<bool, kMaxCorners>> WorstSide() const;
  bool Prepare(const LightReader& reader, const Lens& lens, const Start& start);
  /// The pixels of the board as it lies by now. False if too few corners have some.
  bool Collect(const LightReader& reader, const Lens& lens);
  void StartLevels(const LightReader& reader, const Start& start);
  /// Where the first step runs away: by the pixels around the corners that were found alone, until those lie right,
  /// then by all. False if they run away too, or none are left out.
  bool ComeNearByFound(const LightReader& reader, const Lens& lens, const Start& start);
  void SetDerivatives();
  /// What the kernel is told of the corners' places, and of what changes with every step.
  void SetPlaces();
  void SetLanes();
  /// A step of Gauss-Newton by these sums of the kernel; by shapes alone, the cells' levels stay as they are.
  bool Step(LaneSums sums);
  /// Of the last step, in board coordinates.
  Eigen::Vector2d MoveOf(int corner) const;
  void EvenOutShading(const Start& start);
  void EvenOutPixels(const Shading& shading);
  /// Those beside corners that are not used.
  void FindHiddenCells();
  void HideCellsBeside(const std::array<bool, kMaxCorners>& corners);
  bool AnyHidden() const;
  /// Of a corner's pixels, variances; far off where it has none.
  double Misfit(int corner) const;
  QuadrantLevels LevelsOf(int corner) const { return LevelsAround(size_, corner, own_levels_); }
  /// Where the edge of a shadow crosses cells, they have no one level: fits anew with levels for each corner's
  /// quadrants, if that explains the board better.
  void FitUnevenlyLit(const LightReader& reader, const Lens& lens, const Start& start);
  /// Whether the result's levels tell of one.
  bool InShadow() const;
  /// Whether some corner fits so badly that there may be such an edge.
  bool MayBeUnevenlyLit() const;
  /// Sums of two quadrants' levels each, in the channel that tells light from dark cells best, has most pixels, and
  /// where yellow is nearly white.
  struct QuadrantLight {
    double light, dark;
  };
  QuadrantLight LightAround(int corner) const;
  /// By corner: the light of its light quadrants, over the mean of the corners that are used; 0 for others.
  using CornerLights = std::array<double, kMaxCorners>;
  CornerLights LightOnCorners() const;
  /// Of own levels, those of the cells and the light that falls on them.
  void EvenOutLevels();
  /// Between the light and the dark cells around a corner.
  double Contrast(int corner) const;
  /// Of a corner, since the geometry was that one, px.
  double FarthestMove(const BoardGeometry& from) const;
  /// In the board's middle.
  Eigen::Matrix2d BoardByPixel() const;
  /// Of a cell in the board's middle, along its side.
  double CellPx() const;
  /// What is known by now, for far_cells_.
  FarCells::Known Known() const;
  void TakeOutLight();
  /// Ink that has spread moves the edges of a line to either side by turns: from here on, that is fitted too.
  /// Whether it is so.
  bool StartInk();
  /// Of a board whose corners lie where no plane has them.
  void FitInk(const LightReader& reader, const Lens& lens, const Start& start);
  /// Steps until nothing moves any more.
  bool Settle(const Lens& lens, const Start& start, bool noise_known);
  bool FindHiddenCorners();
  /// Whether the image's edges are no Gaussian's: from here on, they are fitted as they are.
  bool TellEdges();
  void Finish();

  MarkerSize size_;
  int channels_ = 1;
  int red_phase_ = -1;
  std::array<int, 4> channel_of_phase_{};
  BoardPixels pixels_;
  BoardGeometry collected_for_;
  KernelInput input_;
  BoardEquations equations_;
  std::array<CornerDerivative, kMaxCorners> derivatives_;
  std::array<bool, kMaxCorners> left_out_{}, usable_{}, used_{};
  std::vector<PhaseValues> levels_, cell_levels_;
  NoiseModel noise_;
  FittedBoard without_ink_, before_, evenly_lit_, best_;  ///< what a fit is compared with
  FarCells far_cells_;
  bool own_levels_ = false;  ///< levels_ are the quadrants', not the cells'
  bool take_out_ = false, fit_ink_ = false, ink_moves_ = false, bent_light_ = false;
  bool shade_twice_ = false;                ///< the first shading is not good enough for boards as large
  double ink_spread_ = 0;                   ///< cells
  int ink_waits_ = 0;                       ///< passes until it is told anew
  std::vector<std::uint8_t> hidden_cells_;  ///< scratch
  double blur_px_ = 1;
  Eigen::Vector2d smear_px_ = Eigen::Vector2d::Zero();  ///< the way of a point during the exposure
  EdgeShape edges_;
  EdgeProfiles profiles_;
  BoardEquations::Vector step_;
  double misfit_spread_ = 1;       ///< of the usable corners after the last step, the most over the least
  double unexplained_shifts_ = 0;  ///< of corners: their χ² over that of the pixels
  double gain_ = 0;                ///< of the last step: how much Σ w r² falls by it
  double corner_move_px_ = 0;      ///< of the last step: the farthest that a corner moved
  double blur_change_ = 0;         ///< of the last step, as a share
  FittedBoard result_;
};

}  // namespace chequer
