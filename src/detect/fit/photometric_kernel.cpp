#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/fit/photometric_kernel.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include "detect/common/reciprocal-inl.h"
#include "detect/fit/photometric_kernel.h"
#include "detect/fit/plain_light-inl.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Rows of weighted derivatives, with the weighted residual last, kept for a few pixels before they are multiplied: so
/// the sums stay in registers over a chunk. So many take two thirds of a nearest cache of 32 KB; of small cells with
/// AVX2, all of a lane's.
constexpr int kRow = kLaneColumns;
constexpr int kChunk = HWY_MAX_BYTES < 64 ? 24 * 64 / HWY_MAX_BYTES : 24;

/// Where the sums of a vector of lanes stand in their block: each kind at a whole vector of memory.
struct Sums {
  float* first;
  std::ptrdiff_t stride;  ///< from one kind to the next

  HWY_INLINE float* Of(int which) const { return first + which * stride; }
};

/// Products of the columns kFirst … kLast − 1 with all that follow.
constexpr int ProductsOf(int first, int last) { return ProductSum(last - 1, kRow - 1) - ProductSum(first, first) + 1; }

/// sums += Σ over the chunk of row[a] · row[b], a = kFirst … kLast − 1, b = a …: rows of the triangle that share what
/// is loaded, as many as the registers of AVX2 have sums for: in a function of its own, which has them all. Loops over
/// the sums are unrolled, so that these begin and end in registers. @param count ≥ 1.
/// @param anew the sums begin at zero, whatever they were.
template <int kFirst, int kLast>
HWY_NOINLINE void AddProducts(D d, const float* HWY_RESTRICT rows, int count, bool anew, Sums sums) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  constexpr int kProducts = ProductsOf(kFirst, kLast), kFirstProduct = ProductSum(kFirst, kFirst);
  V sum[static_cast<std::size_t>(kProducts)];
  HWY_UNROLL(16)
  for (int i = 0; i < kProducts; ++i) sum[i] = hn::Zero(d);
  int k = 0;
  do {
    const float* HWY_RESTRICT row = rows + k * kRow * lanes;
    V factor[static_cast<std::size_t>(kLast - kFirst)];
    for (int a = kFirst; a < kLast; ++a) factor[a - kFirst] = hn::Load(d, row + a * lanes);
    for (int b = kFirst; b < kRow; ++b) {
      const V other = b < kLast ? factor[b - kFirst] : hn::Load(d, row + b * lanes);
      for (int a = kFirst; a < kLast && a <= b; ++a) {
        V& to = sum[ProductSum(a, b) - kFirstProduct];
        to = hn::MulAdd(factor[a - kFirst], other, to);
      }
    }
  } while (++k < count);
  if (!anew) {
    HWY_UNROLL(16)
    for (int i = 0; i < kProducts; ++i) sum[i] = hn::Add(sum[i], hn::Load(d, sums.Of(kFirstProduct + i)));
  }
  HWY_UNROLL(16)
  for (int i = 0; i < kProducts; ++i) hn::Store(sum[i], d, sums.Of(kFirstProduct + i));
}

HWY_INLINE void AddAllProducts(D d, const float* HWY_RESTRICT rows, int count, bool anew, Sums sums) {
  AddProducts<0, 1>(d, rows, count, anew, sums);
  AddProducts<1, 3>(d, rows, count, anew, sums);
  AddProducts<3, 5>(d, rows, count, anew, sums);
  AddProducts<5, kRow>(d, rows, count, anew, sums);
}

/// The same for the columns that are no levels: few enough for one go.
HWY_INLINE void AddShapeProducts(D d, const float* HWY_RESTRICT rows, int count, bool anew, Sums sums) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  constexpr int kColumns = 4, kColumn[kColumns] = {kShiftX, kShiftY, kBlur, kResidual};
  const auto each_product = [&](auto&& act) HWY_ATTR {
    HWY_UNROLL(4)
    for (int a = 0; a < kColumns; ++a) {
      HWY_UNROLL(4)
      for (int b = a; b < kColumns; ++b) act(a, b, a * kColumns + b);
    }
  };
  V sum[kColumns * kColumns];
  each_product([&](int, int, int product) HWY_ATTR { sum[product] = hn::Zero(d); });
  int k = 0;
  do {
    V value[kColumns];
    for (int a = 0; a < kColumns; ++a) value[a] = hn::Load(d, rows + (k * kRow + kColumn[a]) * lanes);
    each_product([&](int a, int b, int product)
                     HWY_ATTR { sum[product] = hn::MulAdd(value[a], value[b], sum[product]); });
  } while (++k < count);
  each_product([&](int a, int b, int product) HWY_ATTR {
    float* const to = sums.Of(ProductSum(kColumn[a], kColumn[b]));
    hn::Store(anew ? sum[product] : hn::Add(sum[product], hn::Load(d, to)), d, to);
  });
}

/// Puts the sums right where columns were summed without a factor that all pixels of a lane share.
/// @tparam kLevels whether there are sums of levels.
template <bool kLevels>
void ScaleShapes(const KernelInput& input, const LaneBlock& block, int first, Sums sums) {
  const D d;
  const auto per_px = [&](LaneBlock::Parameter px_per_cell)
                          HWY_ATTR { return hn::LoadU(d, block.parameter_data(px_per_cell) + first); };
  const V by_px = hn::Set(d, kDensity / input.blur_px);
  const V scale[3] = {hn::Mul(per_px(LaneBlock::kPxPerCellX), by_px), hn::Mul(per_px(LaneBlock::kPxPerCellY), by_px),
                      hn::Set(d, -kDensity / (kUnit * input.blur_px))};
  for (int a = kShiftX; a <= kBlur; ++a)
    for (int b = a; b < kRow; ++b) {
      if (!kLevels && b >= kLevel00 && b <= kLevel11) continue;
      float* const sum = sums.Of(ProductSum(a, b));
      const V scaled = hn::Mul(hn::Load(d, sum), scale[a]);
      hn::Store(b <= kBlur ? hn::Mul(scaled, scale[b]) : scaled, d, sum);
    }
}

/// Sums beside the products.
struct OtherSums {
  V weight, fit_square, fit_light, fit_count, dark_square, dark_light, dark_count, saturated;
  V uneven_residual, uneven_square, skew_residual, skew_square;
};

/// Fills the row of a pixel. @tparam kSums, kGrown of the input.
template <LaneSums kSums, bool kGrown, class M>
HWY_INLINE void FillRow(const Model& m, const float* HWY_RESTRICT edges, V marked_light, M inside,
                        float* HWY_RESTRICT row, OtherSums& sums) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Predicted p = Predict<kGrown>(m, edges);
  const Weighed w = Weigh(m, p, marked_light, inside);
  const V by_ax = hn::Mul(p.by_ax, w.root), by_ay = hn::Mul(p.by_ay, w.root);
  const auto put = [&](int index, V value) HWY_ATTR { hn::Store(value, d, row + index * lanes); };
  put(kShiftX, by_ax);
  put(kShiftY, by_ay);
  const V by_blur_x = kGrown ? hn::Mul(p.by_blur_x, w.root) : hn::Mul(by_ax, p.ax),
          by_blur_y = kGrown ? hn::Mul(p.by_blur_y, w.root) : hn::Mul(by_ay, p.ay);
  put(kBlur, hn::Add(by_blur_x, by_blur_y));
  put(kResidual, w.deviation);
  const V uneven = hn::Sub(by_blur_x, by_blur_y), skew = hn::Mul(p.by_skew, w.root);
  sums.uneven_residual = hn::MulAdd(uneven, w.deviation, sums.uneven_residual);
  sums.uneven_square = hn::MulAdd(uneven, uneven, sums.uneven_square);
  sums.skew_residual = hn::MulAdd(skew, w.deviation, sums.skew_residual);
  sums.skew_square = hn::MulAdd(skew, skew, sums.skew_square);
  if constexpr (kSums == LaneSums::kShapes) return;
  const V root11 = hn::Mul(p.both, w.root), root_right = hn::Mul(p.right, w.root);
  const V root01 = hn::MulSub(p.down, w.root, root11);
  put(kLevel00, hn::Sub(hn::Sub(w.root, root_right), root01));
  put(kLevel10, hn::Sub(root_right, root11));
  put(kLevel01, root01);
  put(kLevel11, root11);

  sums.weight = hn::Add(sums.weight, w.robust);
  sums.fit_square = hn::MulAdd(w.fit_residual, w.fit_residual, sums.fit_square);
  sums.fit_count = hn::Add(w.fits, sums.fit_count);
  if constexpr (kSums == LaneSums::kNoise) {
    const V dark = hn::IfThenElseZero(hn::Lt(p.light, m.light.middle), w.fits);
    sums.fit_light = hn::MulAdd(p.light, w.fits, sums.fit_light);
    sums.dark_square = hn::MulAdd(hn::Mul(w.fit_residual, w.fit_residual), dark, sums.dark_square);
    sums.dark_light = hn::MulAdd(p.light, dark, sums.dark_light);
    sums.dark_count = hn::Add(dark, sums.dark_count);
    sums.saturated = hn::Add(w.saturated, sums.saturated);
  }
}

/// Where the sums of a lane are read. @tparam kSums of the input.
template <LaneSums kSums>
HWY_INLINE void StoreOtherSums(const OtherSums& sums, int first, LaneBlock& block) {
  const D d;
  const auto finish = [&](LaneSum which, V value) HWY_ATTR { hn::StoreU(value, d, block.sum_data(which) + first); };
  constexpr float kUneven = -kDensity / kUnit, kSkew = kDensity * kDensity;
  finish(kUnevenResidual, hn::Mul(sums.uneven_residual, hn::Set(d, kUneven)));
  finish(kUnevenSquare, hn::Mul(sums.uneven_square, hn::Set(d, kUneven * kUneven)));
  finish(kSkewResidual, hn::Mul(sums.skew_residual, hn::Set(d, kSkew)));
  finish(kSkewSquare, hn::Mul(sums.skew_square, hn::Set(d, kSkew * kSkew)));
  if constexpr (kSums == LaneSums::kShapes) return;
  finish(kWeight, sums.weight);
  finish(kDarkSquare, sums.dark_square);
  finish(kDarkLight, sums.dark_light);
  finish(kDarkCount, sums.dark_count);
  finish(kLightSquare, hn::Sub(sums.fit_square, sums.dark_square));
  finish(kLightLight, hn::Sub(sums.fit_light, sums.dark_light));
  finish(kLightCount, hn::Sub(sums.fit_count, sums.dark_count));
  finish(kSaturatedWeight, sums.saturated);
}

/// Of the lanes from `first` on that fill a vector.
template <LaneSums kSums, bool kGrown>
void AccumulateVector(const KernelInput& input, const Shared& shared, int first, LaneBlock& block) {
  const D d;
  constexpr int kMaxLanes = HWY_MAX_BYTES / sizeof(float);
  const int lanes = static_cast<int>(hn::Lanes(d));
  constexpr int kEdgeValues = kGrown ? int{EdgeRow::kValuesGrown} : int{EdgeRow::kValues};
  HWY_ALIGN float edges[static_cast<std::size_t>(kChunk * kEdgeValues * kMaxLanes)];
  HWY_ALIGN float rows[kChunk * kRow * kMaxLanes];
  const Sums products{block.sum_data(0) + first, block.padded()};
  const V zero = hn::Zero(d);
  const Model m = ModelOf(shared, block, first);
  OtherSums sums{zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, zero};
  const int most = MostOf(block, first);
  if (most == 0 || kSums == LaneSums::kShapes)
    for (int product = 0; product < kProductSums; ++product) hn::Store(zero, d, products.Of(product));
  const int stride = input.stride;
  const std::ptrdiff_t next = stride * LaneBlock::kNextPixel;
  const std::size_t start = block.Place(first, 0);
  const float *u = block.u_data() + start, *v = block.v_data() + start, *light = block.light_data() + start;
  // Pixels of each lane from the one that is looked at on.
  const V step = hn::Set(d, static_cast<float>(stride));
  V left_to_place = m.count, left_to_fill = m.count;
  for (int k = 0; k < most; k += kChunk * stride) {
    const int left = (most - k + stride - 1) / stride, pixels = left < kChunk ? left : kChunk;
    for (int i = 0; i < pixels; ++i, u += next, v += next, left_to_place = hn::Sub(left_to_place, step)) {
      // Beyond a lane's count an earlier board's pixels may stand, which this homography may send to infinity.
      const auto is_inside = hn::Gt(left_to_place, zero);
      PlaceAtEdges(m, hn::IfThenElseZero(is_inside, hn::LoadU(d, u)), hn::IfThenElseZero(is_inside, hn::LoadU(d, v)),
                   edges + i * kEdgeValues * lanes);
    }
    for (int i = 0; i < pixels; ++i) BlurEdges<kGrown>(m, edges + i * kEdgeValues * lanes);
    for (int i = 0; i < pixels; ++i, light += next, left_to_fill = hn::Sub(left_to_fill, step))
      FillRow<kSums, kGrown>(m, edges + i * kEdgeValues * lanes, hn::LoadU(d, light), hn::Gt(left_to_fill, zero),
                             rows + i * kRow * lanes, sums);
    kSums == LaneSums::kShapes ? AddShapeProducts(d, rows, pixels, k == 0, products)
                               : AddAllProducts(d, rows, pixels, k == 0, products);
  }
  ScaleShapes<kSums != LaneSums::kShapes>(input, block, first, products);
  StoreOtherSums<kSums>(sums, first, block);
}

template <bool kGrown>
void AccumulateFirst(const KernelInput& input, int past, LaneBlock& block) {
  const int lanes = static_cast<int>(hn::Lanes(D()));
  const Shared shared = SharedOf(input);
  for (int first = 0; first < past; first += lanes) switch (input.sums) {
      case LaneSums::kShapes: AccumulateVector<LaneSums::kShapes, kGrown>(input, shared, first, block); break;
      case LaneSums::kLevels: AccumulateVector<LaneSums::kLevels, kGrown>(input, shared, first, block); break;
      case LaneSums::kNoise: AccumulateVector<LaneSums::kNoise, kGrown>(input, shared, first, block); break;
    }
}

void Accumulate(const KernelInput& input, LaneBlock& block) {
  const bool all = input.lanes >= block.lanes(), folded = all && block.is_folded();
  if (folded)
    for (int which = 0; which < LaneBlock::kParameters; ++which) block.SpreadFolded(block.parameter_data(which));
  const int past = all ? block.padded() : input.lanes;
  input.grown ? AccumulateFirst<true>(input, past, block) : AccumulateFirst<false>(input, past, block);
  const int filled = input.sums == LaneSums::kShapes ? kWeight : kLaneSums;
  if (folded)
    for (int which = 0; which < filled; ++which) block.GatherFolded(block.sum_data(which));
}

void Mark(float saturation, LaneBlock& block) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V limit = hn::Set(d, saturation);
  for (int first = 0; first < block.padded(); first += lanes) {
    const int most = MostOf(block, first);
    std::size_t at = block.Place(first, 0);
    for (int k = 0; k < most; ++k, at += LaneBlock::kNextPixel) {
      const V light = hn::LoadU(d, block.light_data() + at);
      hn::StoreU(hn::IfThenElse(hn::Ge(light, limit), hn::Neg(limit), light), d, block.light_data() + at);
    }
  }
}

/// @tparam kBent whether the fall has a second order.
template <bool kBent>
void EvenOutBy(const LightFall& fall, const PhaseValues& veil, LaneBlock& block) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V by_u = hn::Set(d, fall.by_u), by_v = hn::Set(d, fall.by_v);
  const V by_uu = hn::Set(d, fall.by_uu), by_uv = hn::Set(d, fall.by_uv), by_vv = hn::Set(d, fall.by_vv);
  const V one = hn::Set(d, 1.0f), half = hn::Set(d, 0.5f), twelfth = hn::Set(d, 1.0f / 12);
  for (int first = 0; first < block.padded(); first += lanes) {
    const int most = MostOf(block, first);
    const V of_phase = lanes < 4 ? hn::LoadU(d, veil.data() + first % 4) : hn::LoadDup128(d, veil.data());
    // Also where no pixel stands: nobody looks there, and a test would cost more.
    std::size_t at = block.Place(first, 0);
    for (int k = 0; k < most; ++k, at += LaneBlock::kNextPixel) {
      const V light = hn::LoadU(d, block.light_data() + at);
      const V u = hn::LoadU(d, block.u_data() + at), v = hn::LoadU(d, block.v_data() + at);
      const V along_u = kBent ? hn::MulAdd(by_uu, u, hn::MulAdd(by_uv, v, by_u)) : by_u;
      const V s = hn::MulAdd(u, along_u, hn::Mul(v, kBent ? hn::MulAdd(by_vv, v, by_v) : by_v));
      // e^−s by its Padé approximant.
      const V even = hn::MulAdd(hn::Mul(s, s), twelfth, one);
      const V scale = hn::Mul(hn::NegMulAdd(s, half, even), Reciprocal(d, hn::MulAdd(s, half, even)));
      // That of a saturated pixel is negative.
      const V over = hn::Xor(of_phase, hn::And(light, hn::SignBit(d)));
      hn::StoreU(hn::MulAdd(hn::Sub(light, over), scale, over), d, block.light_data() + at);
    }
  }
}

void EvenOut(const LightFall& fall, const PhaseValues& veil, LaneBlock& block) {
  const bool bent = fall.by_uu != 0 || fall.by_uv != 0 || fall.by_vv != 0;
  bent ? EvenOutBy<true>(fall, veil, block) : EvenOutBy<false>(fall, veil, block);
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace chequer {
namespace {

HWY_EXPORT(Accumulate);
HWY_EXPORT(EvenOut);
HWY_EXPORT(Mark);

}  // namespace

void AccumulateLanes(const KernelInput& input, LaneBlock& block) { HWY_DYNAMIC_DISPATCH(Accumulate)(input, block); }

void MarkSaturated(float saturation, LaneBlock& block) { HWY_DYNAMIC_DISPATCH(Mark)(saturation, block); }

void LevelNoise(LaneBlock& block) {
  for (int lane = 0; lane < block.lanes(); ++lane) {
    const auto value = [&](LaneBlock::Parameter which) -> float& { return block.parameter_data(which)[lane]; };
    const float light =
        0.25f * (value(LaneBlock::kL00) + value(LaneBlock::kL10) + value(LaneBlock::kL01) + value(LaneBlock::kL11));
    value(LaneBlock::kNoiseFloor) += value(LaneBlock::kNoiseSlope) * std::max(light, 0.0f);
    value(LaneBlock::kNoiseSlope) = 0;
  }
}

void EvenOutLanes(const LightFall& fall, const PhaseValues& veil, LaneBlock& block) {
  HWY_DYNAMIC_DISPATCH(EvenOut)(fall, veil, block);
}

}  // namespace chequer
#endif  // HWY_ONCE
