#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace chequer {

/// A value for each parity of pixel coordinates: phase = parity of x + 2 · parity of y.
using PhaseValues = std::array<float, 4>;

/// The photometric model, evaluated around many corners at once.
///
/// A lane is one corner and one of the four parities of pixel coordinates (so that a lane's pixels share a channel of
/// a mosaic). Its pixels are those nearer to the corner than to others. There the image is
///   I = Σ_ij L_ij w_i(x) w_j(y)   (+ terms for edges that do not meet at right angles, and CornerExcess)
/// with x, y the board coordinates from the corner, L the light of the four cells and w the edges blurred by the lens,
/// w_1(x) = Φ(x · px_per_cell / blur) or what EdgeTerms have instead, w_0 = 1 − w_1. Where cells grow into their
/// neighbours (kGain), edges are moved, and each of two cells that grow has half of where they meet.
/// What Gauss-Newton needs of a lane are the products of these columns; lanes lie side by side in vectors, so that no
/// sum crosses lanes.
enum LaneColumn : int {
  kShiftX,  ///< derivative by a move of the board coordinate x
  kShiftY,
  kBlur,
  kLevel00,  ///< cell towards −x, −y
  kLevel10,  ///< +x, −y
  kLevel01,  ///< −x, +y
  kLevel11,
  kResidual,
  kLaneColumns
};

/// Sums of a lane: first the products of its columns, each weighted by the pixel's weight, the upper triangle by rows.
inline constexpr int kProductSums = kLaneColumns * (kLaneColumns + 1) / 2;
constexpr int ProductSum(int a, int b) {
  const int first = a < b ? a : b, second = a < b ? b : a;
  return first * kLaneColumns - first * (first - 1) / 2 + second - first;
}
enum LaneSum : int {
  // What the pixels say of a blur that is wider across one kind of edge than across the other, and of one that leans:
  // products of the weighted derivatives with the residual, and their squares. Of the plain kernel alone.
  kUnevenResidual = kProductSums,
  kUnevenSquare,
  kSkewResidual,
  kSkewSquare,
  kWeight,      ///< Σ of the robust weights (1 for a pixel that fits)
  kDarkSquare,  ///< Σ r² of the pixels whose model is darker than the lane's middle
  kDarkLight,   ///< Σ of their model
  kDarkCount,
  kLightSquare,
  kLightLight,
  kLightCount,
  kSaturatedWeight,  ///< Σ of saturated pixels' weights, part of kWeight; the plain kernel has it with LaneSums::kNoise
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
    kCorrelation,  ///< of the blur across the two edges: where it is round, the cosine between their normals
    kL00,
    kL10,
    kL01,
    kL11,
    kNoiseFloor,  ///< variance of a pixel = floor + slope · model
    kNoiseSlope,
    kFadeX,  ///< how the root of the window's weight falls to both sides, a cell; 0 where it is 1 throughout
    kFadeY,
    kMiddleX,  ///< from where, cells from the corner
    kMiddleY,
    kPeakX,  ///< what it would be there, if it were not 1 at most
    kPeakY,
    kGain,  ///< by which cells towards −x, −y and +x, +y grow to each side, cells; negative: the other two do so
    kParameters
  };

  /// Lanes that stand together in memory, the lanes of the widest vectors (AVX-512).
  static constexpr int kGroup = 16;
  /// From one pixel of a lane to its next: the three values of the group's other lanes lie between.
  static constexpr std::ptrdiff_t kNextPixel = 3 * kGroup;
  /// Lanes that are folded, and into how many each.
  static constexpr int kFold = 4, kFolds = kGroup / kFold;

  void Reset(int lanes, int pixels_per_lane);
  int lanes() const { return lanes_; }
  /// Lanes in memory: whole groups.
  int padded() const { return padded_; }
  int capacity() const { return capacity_; }

  /// Pixel i of a lane stands at Place(lane, i) of these arrays: its coordinates on the plane, from the block's
  /// origin, and its light. A group's pixels lie in one run of memory, so that what fills them and what reads them
  /// stays within the nearest cache.
  std::size_t Place(int lane, int i) const {
    if (lane >= folded_) lane += i % kFolds * kFold, i /= kFolds;
    return static_cast<std::size_t>((lane / kGroup * capacity_ + i) * kNextPixel + lane % kGroup);
  }
  float* u_data() { return pixels_.data()->values; }
  float* v_data() { return u_data() + kGroup; }
  /// Negative where a pixel is saturated: its light is that or more.
  float* light_data() { return u_data() + 2 * kGroup; }
  const float* u_data() const { return pixels_.data()->values; }
  const float* v_data() const { return u_data() + kGroup; }
  const float* light_data() const { return u_data() + 2 * kGroup; }
  int count(int lane) const { return Visited(lane, 1); }
  /// Of its pixels, those that kernels visit by that stride.
  int Visited(int lane, int stride) const {
    const auto of = [&](int i) { return (counts_[static_cast<std::size_t>(lane + i * kFold)] + stride - 1) / stride; };
    return lane < folded_ ? of(0) : of(0) + of(1) + of(2) + of(3);
  }
  /// Before Fold().
  void SetCount(int lane, int count) { counts_[static_cast<std::size_t>(lane)] = count; }
  /// Where but four lanes stand in the last group: deals the pixels of each to four of the group's, so that they take a
  /// quarter of the vectors. Place() and count() tell of them as if nothing had changed. To be called when all counts
  /// are set.
  void Fold();
  /// Keeps a copy of the pixels as they are.
  void KeepOriginals();
  /// Undoes what was done to the pixels since. @pre they were kept after the last Reset().
  void RestoreOriginals();
  /// First of the lanes that are dealt to others.
  int folded() const { return folded_; }
  bool is_folded() const { return folded_ < padded_; }
  /// Gives the lanes that others were dealt to the values of those. @param values one a lane.
  template <typename Value>
  void SpreadFolded(Value* values) const {
    values += folded_;
    for (int i = kFold; i < kGroup; ++i) values[i] = values[i % kFold];
  }
  /// Adds up their sums. @param sums one a lane.
  void GatherFolded(float* sums) const { GatherGroup(sums + folded_); }
  /// The same, of the group that is folded alone.
  static void GatherGroup(float* sums) {
    for (int i = 0; i < kFold; ++i) sums[i] = (sums[i] + sums[i + kFold]) + (sums[i + 2 * kFold] + sums[i + 3 * kFold]);
  }
  /// Of the lanes as they stand in memory.
  const int* counts() const { return counts_.data(); }

  /// One value a lane.
  float* parameter_data(int which) { return first_parameter() + which * padded_; }
  const float* parameter_data(int which) const { return first_parameter() + which * padded_; }
  float* sum_data(int which) { return first_sum() + which * padded_; }
  const float* sum_data(int which) const { return first_sum() + which * padded_; }
  float sum(int which, int lane) const { return sum_data(which)[lane]; }

 private:
  /// Of a group's lanes, the most that one has.
  int MostOfGroup(int group) const;

  float* first_parameter() { return parameters_.data()->values; }
  const float* first_parameter() const { return parameters_.data()->values; }
  float* first_sum() { return sums_.data()->values; }
  const float* first_sum() const { return sums_.data()->values; }

  /// One value of all of a group's lanes: the widest vector, in one line of the cache.
  struct alignas(kGroup * sizeof(float)) GroupValues {
    float values[kGroup];
  };

  int lanes_ = 0, padded_ = 0, capacity_ = 0, folded_ = 0;
  std::vector<GroupValues> pixels_, sums_, originals_, parameters_;
  std::vector<int> counts_;
};

}  // namespace chequer
