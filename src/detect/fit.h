#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "detect/banded.h"
#include "detect/board_geometry.h"
#include "detect/light.h"
#include "detect/photometric_kernel.h"

namespace chequer {

/// A board after the joint photometric fit.
struct FittedBoard {
  BoardGeometry geometry;
  /// Of the geometry's parameters, from the information of all pixels, with the levels, the blur and the noise as
  /// measured in this board.
  Eigen::MatrixXd covariance;
  /// −2 log likelihood of the pixels at the noise of this fit, up to a constant: compares two fits of one board.
  double misfit = 0;
  /// Standard deviation of a corner as seen by its own pixels alone, pixels.
  double corner_deviation_px = 0;
  double blur_px = 1;
  /// Contrast of the board, light, over the standard deviation of a pixel that the model does not explain.
  double signal_to_noise = 0;
  /// Light of each cell, row by row, by channel; the other channels are zero.
  std::vector<Eigen::Vector3f> levels;
  std::array<bool, kMaxCorners> corner_used{};
  int corners_used = 0;
  double reprojection_rms_px = 0;
};

/// Fits geometry, cell levels (free for every cell and channel), blur and noise of one board to its pixels, by
/// Gauss-Newton on the model of photometric_kernel.h, the levels eliminated by the Schur complement (detection.md 3.4
/// gives the derivation; Krüger and Yang have the corner-wise model). Keeps its memory.
class PhotometricFit {
 public:
  struct Start {
    MarkerSize size;
    BoardGeometry geometry;
    double blur_px = 0.8;
    /// Saturation of each cell as far as known before the fit, row by row, for telling shading from ink.
    std::vector<bool> saturated;
  };

  /// Nothing if the board lies outside the image for the most part, does not look like the model, or the fit runs away.
  /// The result is valid until the next call.
  const FittedBoard* Fit(const LightReader& reader, const Lens& lens, const Start& start);

 private:
  /// Geometry, then the blur; of a pose, parameters 6 and 7 stay unused.
  static constexpr int kUnknowns = BoardGeometry::kMaxParameters + 1;
  static constexpr int kBlurUnknown = BoardGeometry::kMaxParameters;
  /// Right-hand sides of the levels: the unknowns above, then the residuals.
  static constexpr int kResidualColumn = kUnknowns;
  static_assert(kResidualColumn + 1 == BandedSystem::kColumns);

  struct CornerPlace {
    Eigen::Vector2d board;
    Eigen::Vector2d pixel;
    Eigen::Matrix2d pixel_by_board;
    bool inside = false;
  };

  bool Prepare(const LightReader& reader, const Lens& lens, const Start& start);
  void PlaceCorners(const LightReader& reader, const Lens& lens);
  void CollectPixels(const LightReader& reader, const Lens& lens, int corner);
  void StartLevels();
  void SetLanes();
  bool Step(double* largest_move_px);
  void AssembleGeometry();
  void AssembleNormal();
  void AddCorner(int corner);
  void EliminateLevels();
  void MoveLevels(const Eigen::Matrix<double, kUnknowns, 1>& step);
  void EstimateNoise();
  void EvenOutShading(const Start& start);
  void DropHiddenCorners();
  void Finish();

  int Lane(int phase, int corner) const { return phase * corners_ + corner; }

  MarkerSize size_;
  int corners_ = 0, cells_ = 0, channels_ = 1;
  std::array<int, 4> channel_of_phase_{};
  std::array<CornerPlace, kMaxCorners> places_;
  std::array<bool, kMaxCorners> hidden_{};
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();  ///< of the block's plane coordinates
  double blur_px_ = 1;
  std::array<float, 3> noise_floor_{}, noise_slope_{};
  LaneBlock block_;
  KernelInput input_;
  std::array<std::vector<float>, 3> levels_;  ///< by channel
  /// Normal equations of the geometry and the blur (last), and of the levels of each channel.
  Eigen::Matrix<double, kUnknowns, kUnknowns> normal_;
  Eigen::Matrix<double, kUnknowns, 1> gradient_;
  std::array<BandedSystem, 3> level_systems_;
  /// By corner: the four local parameters by the geometry's parameters; zero beyond their number (fixed sizes are
  /// several times quicker).
  std::vector<Eigen::Matrix<double, 4, 8>> local_by_geometry_;
  FittedBoard result_;
};

}  // namespace chequer
