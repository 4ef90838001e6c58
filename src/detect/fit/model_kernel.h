#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "detect/fit/edge_noise.h"
#include "detect/fit/lane_block.h"
#include "detect/fit/photometric_kernel.h"
#include "detect/fit/terms.h"

namespace chequer {

/// The model of a board's picture with all its terms, evaluated around many corners at once.
///
/// Around a corner lie 4 × 4 cells of one level each. Their picture is
///   M(x, y) = Σ_ij L_ij (s_i(x) s_j(y) + ρ s_i′(x) s_j′(y) + ½ ρ² s_i″(x) s_j″(y)),
/// with x, y the distance from the corner in cells, s the cells' shares as the lens blurs their edges and ρ the
/// covariance of the blur along x and y (its square only where cells are seen as rhombi). The terms (terms.h) bend it:
/// what lies in its points, or what light falls on them.
/// photometric_kernel.h is the same without terms, for cells so large that the four around a corner suffice: the fast
/// path of boards in plain view.

/// Which columns the products of a lane have: derivatives of the light by each unknown, the residual last.
struct ModelColumns {
  static constexpr int kGeometry = 8;  ///< as BoardGeometry::MoveByParameters() has them
  static constexpr int kMostShared = kGeometry + 1 + Terms::kColumns;
  static constexpr int kLevels = 16;
  static constexpr int kMost = kMostShared + kLevels + 1;

  explicit ModelColumns(const ModelTerms& terms);

  int blur = kGeometry;
  int shared = 0;  ///< all of these
  int levels = 0;  ///< the first of the 4 × 4 cells around, row by row
  int count = 0;   ///< with the residual

  /// Of a term that is on, the first.
  template <class Term>
  int of() const {
    return first_[Terms::BeforeTerm<Term>().terms];
  }
  int residual() const { return count - 1; }
  /// Products are made in blocks of two columns by four, which stand one after the other: of a pair of columns, those
  /// with the four that it lies in and all later ones. Some of them are of no use.
  static constexpr int kPair = 2, kBlock = 4, kInBlock = kPair * kBlock;
  /// Where a product of two columns stands, a ≤ b.
  int Product(int a, int b) const { return Row(a) + Along(b); }
  /// The two parts of that, for those who go through many.
  int Row(int a) const {
    const int pair = a / kPair;
    return kInBlock * (BlocksBefore(pair) - pair * kPair / kBlock) + a % kPair * kBlock;
  }
  static int Along(int b) { return b / kBlock * kInBlock + b % kBlock; }
  int products() const { return kInBlock * BlocksBefore((count + 1) / kPair); }

 private:
  /// Blocks of the pairs before this one: pair q lacks the q / 2 blocks left of its own.
  int BlocksBefore(int pair) const { return pair * ((count + kBlock - 1) / kBlock) - (pair - 1) * (pair - 1) / 4; }

  int first_[Terms::kCount] = {};
};

/// What lanes are given for the model, and what it sums up for them. Memory is kept; contents are those of the last
/// board until they are written.
class ModelLanes {
 public:
  enum Parameter {
    kCornerX,  ///< board coordinates of the corner
    kCornerY,
    kScaleX,  ///< standard deviations of a tap's blur a cell
    kScaleY,
    kBlurX,  ///< how the logarithm of that blur grows with the lens's, 1 / px
    kBlurY,
    kCovariance,  ///< of the blur, cells²
    kSkew,        ///< the same where edges are far from square to each other, or 0: see Twist()
    kSkewByBlur,  ///< how that grows with the lens's, cells² / px
    kByPixelXx,   ///< derivative of the board by the image, row by row
    kByPixelXy,
    kByPixelYx,
    kByPixelYy,
    kNoiseFloor,  ///< variance of a pixel = floor + slope · model
    kNoiseSlope,
    kFadeX,  ///< as LaneBlock has them
    kFadeY,
    kMiddleX,
    kMiddleY,
    kPeakX,
    kPeakY,
    kOfTerms,                             ///< Terms::kLanes of them
    kLevel00 = kOfTerms + Terms::kLanes,  ///< of the 4 × 4 cells, row by row
    kParameters = kLevel00 + ModelColumns::kLevels
  };

  /// A term's own.
  template <class Term>
  static constexpr int Of(int which) {
    return kOfTerms + Terms::BeforeTerm<Term>().lanes + which;
  }

  void Reset(int padded_lanes, int products);
  float* parameter_data(int which) { return parameters_.data() + which * padded_; }
  const float* parameter_data(int which) const { return parameters_.data() + which * padded_; }
  /// The sum of a product for a lane. Those of a group of lanes stand together, kNextProduct from one product to the
  /// next.
  static constexpr int kNextProduct = LaneBlock::kGroup;
  float* sum_data(int product, int lane) { return sums_.data() + Place(product, lane); }
  const float* sum_data(int product, int lane) const { return sums_.data() + Place(product, lane); }
  int products() const { return products_; }

 private:
  std::ptrdiff_t Place(int product, int lane) const {
    return static_cast<std::ptrdiff_t>(lane / LaneBlock::kGroup * products_ + product) * kNextProduct +
           lane % LaneBlock::kGroup;
  }

  int padded_ = 0, products_ = 0;
  std::vector<float> parameters_, sums_;
};

/// What all lanes share.
struct ModelInput : Terms::Inputs {
  ModelTerms terms;
  float board_from_plane[9] = {};  ///< as KernelInput has it
  EdgeTerms edge_x, edge_y;
  float robust_limit = 1e9f;
  int stride = 1;  ///< every how many of a lane's pixels are used, ≥ 1
};

/// Evaluates the model and its derivatives at the pixels of a block and sums up their weighted products in `model`; the
/// block gets what EstimateNoise() and the search for occluded corners read: the sums from kWeight on and that of the
/// squared residuals.
void AccumulateModel(const ModelInput& input, LaneBlock& block, ModelLanes& model);

/// Adds up the errors of all groups and places. @param input,model as the lanes were last evaluated with.
/// @param blur_px the lens's. @param places null: they are not asked.
void AddEdgeErrors(const ModelInput& input, const LaneBlock& block, const ModelLanes& model, float blur_px,
                   AlikeEdges& x, AlikeEdges& y, AlikePlaces* places);

}  // namespace chequer
