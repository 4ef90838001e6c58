#pragma once

#include <array>
#include <limits>

#include "detect/fit/lane_block.h"

namespace chequer {

/// What an edge's light leaves beyond |a| > 0, a in standard deviations of the blur: e^(−a²/2) (½ + Σ by_power[n − 1]
/// |a|ⁿ). As they are here, a Gaussian's, to 5e-5. The derivatives by the edge's place are a Gaussian's for all.
struct EdgeTerms {
  static constexpr int kTerms = 6;
  std::array<float, kTerms> by_power{-3.9820984e-1f, 2.4442466e-1f, -1.1694271e-1f,
                                     3.967331e-2f,   -8.04221e-3f,  7.0427e-4f};
};

/// What a corner's light has beside the product of its two edges' and what they lack to a right angle: φ(a) φ(b) times
///   (square (a² − b²) + product a b) (1 − kFall (a² + b²)) + moved_x (a² − 1) + moved_y (b² − 1) + moved_product a b
/// of what the cells across differ by, a and b in standard deviations of the blur from the edges, φ the normal
/// distribution's density. The first is the lens's, the rest that of a motion during the exposure.
struct CornerExcess {
  static constexpr float kFall = 0.2235f;
  float square = 0, product = 0;
  float moved_x = 0, moved_y = 0, moved_product = 0;

  bool none() const { return *this == CornerExcess{}; }
  bool operator==(const CornerExcess&) const = default;
};

/// Which sums are wanted.
enum class LaneSums {
  kShapes,  ///< products of columns that are no levels, alone
  kLevels,  ///< all products, the weights; all pixels count as light ones, whose Σ of the model is not told
  kNoise,   ///< all
};

/// What all lanes share.
struct KernelInput {
  float board_from_plane[9] = {};  ///< homography, row by row, of plane coordinates from the block's origin
  float blur_px = 1;               ///< standard deviation of the Gaussian, pixels
  EdgeTerms edge_x, edge_y;        ///< of edges of constant x and of constant y
  CornerExcess corner;
  /// Of a board that turned during the exposure, how much narrower the blur across the edges of constant x gets with
  /// each of its standard deviations along y, as a share of it; and the reverse.
  float narrower_x = 0, narrower_y = 0;
  bool grown = false;         ///< some lane has a LaneBlock::kGain
  float robust_limit = 1e9f;  ///< residuals beyond so many standard deviations count with less weight (Huber)
  LaneSums sums = LaneSums::kNoise;
  int stride = 1;         ///< every how many of a lane's pixels are used, ≥ 1
  int lanes = kAllLanes;  ///< the first so many are looked at
  static constexpr int kAllLanes = std::numeric_limits<int>::max();
};

/// Evaluates model and derivatives at all pixels and fills the wanted sums of the lanes that are looked at; their other
/// products are zero, the other sums left alone.
void AccumulateLanes(const KernelInput& input, LaneBlock& block);

/// Weighs all pixels of a lane alike, by the noise of its mean light. @pre levels and noise are set.
void LevelNoise(LaneBlock& block);

/// How the logarithm of the light changes over the plane: by u and v, their squares and their product.
struct LightFall {
  float by_u = 0, by_v = 0, by_uu = 0, by_uv = 0, by_vv = 0;
};

/// Takes it out of every pixel (to 1e-5 where it is up to 0.5). @param veil by phase: light that does not fall off.
void EvenOutLanes(const LightFall& fall, const PhaseValues& veil, LaneBlock& block);

/// Negates the light of pixels from `saturation` on, which say no more than "at least that much": whatever is done to
/// the light afterwards, they are known by it. @pre the pixels were just collected.
void MarkSaturated(float saturation, LaneBlock& block);

}  // namespace chequer
