#pragma once

#include <cstddef>
#include <vector>

namespace chequer {

/// The photometric model, evaluated around many corners at once.
///
/// A lane is one corner and one of the four parities of pixel coordinates (so that a lane's pixels share a channel of
/// a mosaic). Its pixels are those nearer to the corner than to others. There the image is
///   I = Σ_ij L_ij w_i(x) w_j(y)   (+ a term for edges that do not meet at right angles)
/// with x, y the board coordinates from the corner, L the light of the four cells and w the edges blurred by the lens,
/// w_1(x) = Φ(x · px_per_cell / blur), w_0 = 1 − w_1.
/// What Gauss-Newton needs of a lane is its normal matrix in nine local parameters; lanes lie side by side in
/// vectors, so that no sum crosses lanes.
inline constexpr int kLaneParameters = 9;
enum LaneParameter : int {
  kShiftX,        ///< of the coordinate x, at the corner
  kShiftXAlongY,  ///< its growth along y
  kShiftY,
  kShiftYAlongX,
  kBlur,
  kLevel00,  ///< cell towards −x, −y
  kLevel10,  ///< +x, −y
  kLevel01,  ///< −x, +y
  kLevel11,
};

/// Sums of a lane: the upper triangle of JᵀWJ by rows, JᵀWr, then the following.
inline constexpr int kNormalSums = kLaneParameters * (kLaneParameters + 1) / 2;
enum LaneSum : int {
  kGradient = kNormalSums,                   ///< first of JᵀWr
  kChiSquare = kGradient + kLaneParameters,  ///< Σ w r²
  kWeight,                                   ///< Σ of the robust weights (1 for a pixel that fits)
  kDarkSquare,                               ///< Σ r² of the pixels whose model is darker than the lane's middle
  kDarkLight,                                ///< Σ of their model
  kDarkCount,
  kLightSquare,
  kLightLight,
  kLightCount,
  kLaneSums
};

/// Structure of arrays; the memory is kept.
class LaneBlock {
 public:
  /// What a lane is given, one array each.
  enum Parameter {
    kCornerX,  ///< board coordinates of the corner
    kCornerY,
    kPxPerCellX,  ///< image pixels of one cell across edges of constant x
    kPxPerCellY,
    kCorrelation,  ///< cosine between the normals of the two edges
    kL00,
    kL10,
    kL01,
    kL11,
    kNoiseFloor,  ///< variance of a pixel = floor + slope · model
    kNoiseSlope,
    kParameters
  };

  /// Empties all lanes. @param samples_per_lane the most a lane can take.
  void Reset(int lanes, int samples_per_lane);
  int lanes() const { return lanes_; }
  int padded() const { return padded_; }
  int count(int lane) const { return counts_[static_cast<std::size_t>(lane)]; }
  int capacity() const { return capacity_; }

  /// Adds a pixel; when the lane is full it is left out. u, v: plane coordinates from the block's origin.
  void Add(int lane, float u, float v, float light) {
    int& count = counts_[static_cast<std::size_t>(lane)];
    if (count == capacity_) return;
    const std::size_t at = static_cast<std::size_t>(count * padded_ + lane);
    u_[at] = u;
    v_[at] = v;
    light_[at] = light;
    ++count;
  }
  void ClearLane(int lane) { counts_[static_cast<std::size_t>(lane)] = 0; }
  float& light(int lane, int index) { return light_[static_cast<std::size_t>(index * padded_ + lane)]; }
  float u(int lane, int index) const { return u_[static_cast<std::size_t>(index * padded_ + lane)]; }
  float v(int lane, int index) const { return v_[static_cast<std::size_t>(index * padded_ + lane)]; }

  float& parameter(Parameter which, int lane) { return parameters_[static_cast<std::size_t>(which * padded_ + lane)]; }
  float sum(int which, int lane) const { return sums_[static_cast<std::size_t>(which * padded_ + lane)]; }

  const float* u_data() const { return u_.data(); }
  const float* v_data() const { return v_.data(); }
  const float* light_data() const { return light_.data(); }
  const float* parameter_data(int which) const { return parameters_.data() + which * padded_; }
  const int* counts() const { return counts_.data(); }
  float* sum_data(int which) { return sums_.data() + which * padded_; }

 private:
  int lanes_ = 0, padded_ = 0, capacity_ = 0;
  std::vector<float> u_, v_, light_, parameters_, sums_;
  std::vector<int> counts_;
};

/// What all lanes share.
struct KernelInput {
  float board_from_plane[9] = {};  ///< homography, row by row, of plane coordinates from the block's origin
  float blur_px = 1;               ///< standard deviation of the Gaussian, pixels
  float saturation = 1;            ///< light from which on a pixel only says "at least that much"
  float robust_limit = 1e9f;       ///< residuals beyond so many standard deviations count with less weight (Huber)
  int stride = 1;                  ///< every how many of a lane's pixels are used, ≥ 1
};

/// Evaluates model and derivatives at all pixels and fills the sums of all lanes.
void AccumulateLanes(const KernelInput& input, LaneBlock& block);

}  // namespace chequer
