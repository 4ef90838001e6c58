#pragma once

#include <Eigen/Core>
#include <array>

#include "chequer/marker.h"
#include "detect/common/board_geometry.h"
#include "detect/common/fixed_vector.h"

namespace chequer {

/// A value that moves a little from frame to frame: how well it is known, and how far it moves.
struct WalkingValue {
  double variance = 0;  ///< of what is known of it, for this frame
  double step = 0;      ///< variance of its move from one frame to the next, as measured: noise may make it negative
  // Since a frame last showed it:
  int frames = 0;
  double aged_by = 0;  ///< the part of `variance` that moves have added

  void Age(int frames_on, double step_at_least);
  /// Learns from a frame's own estimate. @param excess what the square of its difference from the prediction has beyond
  /// what both variances explain. @param most beyond which it tells nothing more. @pre aged since the last one.
  void LearnStep(double excess, double most);
};

/// What the frames of a stream have shown of the levels of a board's cells. Handed on from frame to frame
/// (RememberedBoard).
struct LearntBoard {
  /// By cell and channel, in the illumination of the last frame; empty: nothing was learnt.
  FixedVector<std::array<float, 3>, kMaxCells> levels;
  /// Of all levels together: variance of the logarithm of their illumination, were it the only unknown. It stands for
  /// the whole covariance of the levels, which has the form of that of one frame.
  WalkingValue light;

  bool known() const { return levels.size() > 0; }
};

/// The normal equations of a fit that has ended, for the unknowns that all corners share (geometry, blur) and for some
/// combinations of levels: the difference of the frame's own estimate from what was learnt, then by channel the ways in
/// which illumination may change them all.
struct LevelProducts {
  static constexpr int kShared = BoardGeometry::kParameters + 1;
  static constexpr int kLights = 3;  ///< brighter, brighter to the right, brighter below
  static constexpr int kMost = kShared + 1 + 3 * kLights;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;
  using SharedSquare = Eigen::Matrix<double, kShared, kShared>;

  int channels;
  Matrix products = Matrix::Zero(light(channels), light(channels));

  explicit LevelProducts(int channel_count) : channels(channel_count) {}
  /// Adds products of a channel's levels, as moved by the difference and by light: with the shared unknowns, and with
  /// each other. Above the diagonal; Mirror() fills in the rest.
  template <class ByShared, class Square>
  void Add(int channel, const ByShared& by_shared, const Square& square) {
    products.template block<kShared, 1>(0, kShared) += by_shared.col(0);
    products.template block<kShared, kLights>(0, light(channel)) += by_shared.template rightCols<kLights>();
    products(kShared, kShared) += square(0, 0);
    products.template block<1, kLights>(kShared, light(channel)) += square.template topRightCorner<1, kLights>();
    products.template block<kLights, kLights>(light(channel), light(channel)) +=
        square.template bottomRightCorner<kLights, kLights>();
  }
  void Mirror() { products.triangularView<Eigen::StrictlyLower>() = products.transpose(); }
  int light(int channel) const { return kShared + 1 + kLights * channel; }
  int lights() const { return kLights * channels; }
  /// Of what is added up so far: on the logarithm of the illumination.
  double LightInformation() const;
};

/// What a fit has found by its own frame alone, pixels worth one unit each.
struct OwnEstimate {
  LevelProducts::SharedSquare covariance = LevelProducts::SharedSquare::Zero();
  double pixel_variance = 1;  ///< that their units have
  int levels = 0;             ///< cells times channels
};

/// How a fit changes by what was learnt.
struct LearntStep {
  LevelProducts::SharedSquare covariance = LevelProducts::SharedSquare::Zero();
  Eigen::Matrix<double, LevelProducts::kShared, 1> moves = Eigen::Matrix<double, LevelProducts::kShared, 1>::Zero();
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3 * LevelProducts::kLights, 1> lights;  ///< how illumination changed
  double share = 0;  ///< of the remaining difference, by which the levels move towards what was learnt
};

/// Combines a frame's own estimate with what earlier frames have shown, and updates `light`, by which that is known.
/// Exact where the earlier frames showed the board alike and its levels did not change, up to how they are lit: what
/// was learnt is a Gaussian prior on levels, of the form of this frame's own information on them. False, and only this
/// frame is learnt, where both contradict each other: then the step has a share of 0, and no moves.
bool UseLearnt(const LevelProducts& products, const OwnEstimate& own, WalkingValue& light, LearntStep& step);
/// What is known by the first frame.
WalkingValue StartLearning(const LevelProducts& products, const OwnEstimate& own);

}  // namespace chequer
