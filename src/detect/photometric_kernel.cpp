#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/photometric_kernel.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include "detect/photometric_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

/// Reciprocal and reciprocal square root: the hardware's estimate and a step of Newton's (relative error below 1e-5
/// from 12 good bits), a third of what the exact ones cost.
HWY_INLINE V Reciprocal(D d, V x) {
  const V estimate = hn::ApproximateReciprocal(x);
  return hn::Mul(estimate, hn::NegMulAdd(x, estimate, hn::Set(d, 2.0f)));
}
HWY_INLINE V ReciprocalSqrt(D d, V x) {
  const V estimate = hn::ApproximateReciprocalSqrt(x);
  const V half = hn::Mul(hn::Mul(x, hn::Set(d, 0.5f)), estimate);
  return hn::Mul(estimate, hn::NegMulAdd(half, estimate, hn::Set(d, 1.5f)));
}

/// 2^x for −60 ≤ x ≤ 0, to 8e-5 of it: the exponent's bits times a polynomial of the rest, best over −½..½.
HWY_INLINE V PowerOfTwo(D d, V x) {
  const hn::RebindToSigned<D> di;
  const auto whole = hn::NearestInt(x);
  const V f = hn::Sub(x, hn::ConvertTo(d, whole));
  V p = hn::MulAdd(hn::Set(d, 5.51717e-2f), f, hn::Set(d, 2.4261163e-1f));
  p = hn::MulAdd(p, f, hn::Set(d, 6.9326102e-1f));
  p = hn::MulAdd(p, f, hn::Set(d, 9.9992804e-1f));
  return hn::Mul(p, hn::BitCast(d, hn::ShiftLeft<23>(hn::Add(whole, hn::Set(di, 127)))));
}

/// Normal distribution: its density and its integral up to a.
struct Normal {
  V density, integral;
};

/// The integral to 5e-5: what lies beyond |a| is the exponential times a polynomial, best over 0..5.
HWY_INLINE Normal NormalAt(D d, V a) {
  const V size = hn::Min(hn::Abs(a), hn::Set(d, 5.0f));
  const V e = PowerOfTwo(d, hn::Mul(hn::Mul(size, size), hn::Set(d, -0.72134752f)));
  V p = hn::MulAdd(hn::Set(d, 7.0427e-4f), size, hn::Set(d, -8.04221e-3f));
  p = hn::MulAdd(p, size, hn::Set(d, 3.967331e-2f));
  p = hn::MulAdd(p, size, hn::Set(d, -1.1694271e-1f));
  p = hn::MulAdd(p, size, hn::Set(d, 2.4442466e-1f));
  p = hn::MulAdd(p, size, hn::Set(d, -3.9820984e-1f));
  p = hn::MulAdd(p, size, hn::Set(d, 4.9998433e-1f));
  const V beyond = hn::Mul(p, e);
  const V integral = hn::IfThenElse(hn::Lt(a, hn::Zero(d)), beyond, hn::Sub(hn::Set(d, 1.0f), beyond));
  return {hn::Mul(e, hn::Set(d, 0.39894228f)), integral};
}

/// Rows of weighted derivatives, with the weighted residual last, kept for a few pixels before they are multiplied: so
/// the sums stay in registers over a chunk.
constexpr int kRow = kLaneColumns;
constexpr int kChunk = 8;

/// Products of the columns kFirst … kLast − 1 with all that follow.
constexpr int ProductsOf(int first, int last) { return ProductSum(last - 1, kRow - 1) - ProductSum(first, first) + 1; }

/// sums += Σ over the chunk of row[a] · row[b], a = kFirst … kLast − 1, b = a …: rows of the triangle that share what
/// is loaded, as many as the registers of AVX2 have sums for.
template <int kFirst, int kLast>
HWY_INLINE void AddProducts(D d, const float* HWY_RESTRICT rows, int count, float* HWY_RESTRICT sums) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  constexpr int kProducts = ProductsOf(kFirst, kLast);
  sums += ProductSum(kFirst, kFirst) * lanes;
  V sum[static_cast<std::size_t>(kProducts)];
  for (int i = 0; i < kProducts; ++i) sum[i] = hn::Load(d, sums + i * lanes);
  for (int k = 0; k < count; ++k) {
    const float* HWY_RESTRICT row = rows + k * kRow * lanes;
    V factor[static_cast<std::size_t>(kLast - kFirst)];
    for (int a = kFirst; a < kLast; ++a) factor[a - kFirst] = hn::Load(d, row + a * lanes);
    for (int b = kFirst; b < kRow; ++b) {
      const V other = b < kLast ? factor[b - kFirst] : hn::Load(d, row + b * lanes);
      for (int a = kFirst; a < kLast && a <= b; ++a) {
        V& to = sum[ProductSum(a, b) - ProductSum(kFirst, kFirst)];
        to = hn::MulAdd(factor[a - kFirst], other, to);
      }
    }
  }
  for (int i = 0; i < kProducts; ++i) hn::Store(sum[i], d, sums + i * lanes);
}

HWY_INLINE void AddAllProducts(D d, const float* HWY_RESTRICT rows, int count, float* HWY_RESTRICT sums) {
  AddProducts<0, 1>(d, rows, count, sums);
  AddProducts<1, 3>(d, rows, count, sums);
  AddProducts<3, 5>(d, rows, count, sums);
  AddProducts<5, kRow>(d, rows, count, sums);
}

void Accumulate(const KernelInput& input, LaneBlock& block) {
  const D d;
  constexpr int kMaxLanes = HWY_MAX_BYTES / sizeof(float);
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int padded = block.padded();
  const V inverse_blur = hn::Set(d, 1.0f / input.blur_px);
  const V one = hn::Set(d, 1.0f), zero = hn::Zero(d);
  const V limit_square = hn::Set(d, input.robust_limit * input.robust_limit);
  const V limit = hn::Set(d, input.robust_limit);
  const V saturation = hn::Set(d, input.saturation);
  V h[9];
  for (int i = 0; i < 9; ++i) h[i] = hn::Set(d, input.board_from_plane[i]);
  HWY_ALIGN float rows[kChunk * kRow * kMaxLanes];
  HWY_ALIGN float products[kProductSums * kMaxLanes];

  for (int first = 0; first < padded; first += lanes) {
    int most = 0;
    HWY_ALIGN float counts[kMaxLanes];
    for (int i = 0; i < lanes; ++i) {
      most = most > block.counts()[first + i] ? most : block.counts()[first + i];
      counts[i] = static_cast<float>(block.counts()[first + i]);
    }
    const V count = hn::Load(d, counts);
    const auto parameter = [&](LaneBlock::Parameter which) {
      return hn::LoadU(d, block.parameter_data(which) + first);
    };
    const V corner_x = parameter(LaneBlock::kCornerX), corner_y = parameter(LaneBlock::kCornerY);
    const V scale_x = hn::Mul(parameter(LaneBlock::kPxPerCellX), inverse_blur);
    const V scale_y = hn::Mul(parameter(LaneBlock::kPxPerCellY), inverse_blur);
    const V correlation = parameter(LaneBlock::kCorrelation);
    const V l00 = parameter(LaneBlock::kL00), l10 = parameter(LaneBlock::kL10);
    const V l01 = parameter(LaneBlock::kL01), l11 = parameter(LaneBlock::kL11);
    const V noise_floor = parameter(LaneBlock::kNoiseFloor), noise_slope = parameter(LaneBlock::kNoiseSlope);
    const V cross = hn::Sub(hn::Add(l00, l11), hn::Add(l10, l01));
    const V middle = hn::Mul(hn::Add(hn::Add(l00, l11), hn::Add(l10, l01)), hn::Set(d, 0.25f));

    for (int i = 0; i < kProductSums * lanes; i += lanes) hn::Store(zero, d, products + i);
    V weight_sum = zero, fit_square = zero, fit_light = zero, fit_count = zero;
    V dark_square = zero, dark_light = zero, dark_count = zero;
    int in_chunk = 0;
    // Copies, which no store can change.
    const bool tell_dark = input.tell_dark;
    const int stride = input.stride;
    const float *u_at = block.u_data() + block.Place(first, 0), *v_at = block.v_data() + block.Place(first, 0),
                *light_at = block.light_data() + block.Place(first, 0);
    for (int k = 0; k < most; k += stride, u_at += stride * LaneBlock::kNextPixel,
             v_at += stride * LaneBlock::kNextPixel, light_at += stride * LaneBlock::kNextPixel) {
      const auto inside = hn::Lt(hn::Set(d, static_cast<float>(k)), count);
      // Beyond a lane's count an earlier board's pixels may stand, which this homography may send to infinity.
      const V u = hn::IfThenElseZero(inside, hn::LoadU(d, u_at));
      const V v = hn::IfThenElseZero(inside, hn::LoadU(d, v_at));
      const V light = hn::LoadU(d, light_at);

      const V w = Reciprocal(d, hn::MulAdd(h[6], u, hn::MulAdd(h[7], v, h[8])));
      const V x = hn::MulSub(hn::MulAdd(h[0], u, hn::MulAdd(h[1], v, h[2])), w, corner_x);
      const V y = hn::MulSub(hn::MulAdd(h[3], u, hn::MulAdd(h[4], v, h[5])), w, corner_y);
      const V ax = hn::Mul(x, scale_x), ay = hn::Mul(y, scale_y);
      const Normal nx = NormalAt(d, ax), ny = NormalAt(d, ay);

      // Cells' shares. Edges that are not square to each other blur together: the shares are those of a bivariate
      // normal distribution, to first order in the correlation.
      const V twist = hn::Mul(correlation, hn::Mul(nx.density, ny.density));
      const V left = hn::Sub(one, nx.integral), up = hn::Sub(one, ny.integral);
      const V w00 = hn::MulAdd(left, up, twist), w10 = hn::MulSub(nx.integral, up, twist);
      const V w01 = hn::MulSub(left, ny.integral, twist), w11 = hn::MulAdd(nx.integral, ny.integral, twist);
      const V model = hn::MulAdd(w00, l00, hn::MulAdd(w10, l10, hn::MulAdd(w01, l01, hn::Mul(w11, l11))));

      // A saturated pixel agrees with every model that saturates too.
      const auto agrees = hn::And(hn::Ge(light, saturation), hn::Ge(model, light));
      const auto used = hn::AndNot(agrees, inside);
      const V usable = hn::IfThenElseZero(used, one);
      const V residual = hn::IfThenElseZero(used, hn::Sub(light, model));

      // Root of the weight, so that rows carry it. Huber: beyond the limit the weight falls as 1 / deviation.
      const V variance = hn::MulAdd(noise_slope, hn::Max(model, zero), noise_floor);
      V root = hn::IfThenElseZero(used, ReciprocalSqrt(d, variance));
      const V deviation = hn::Mul(residual, root);
      const V deviation_square = hn::Mul(deviation, deviation);
      const auto off = hn::Gt(deviation_square, limit_square);
      V robust = usable;
      if (HWY_UNLIKELY(!hn::AllFalse(d, off))) {
        robust = hn::IfThenElse(off, hn::Mul(limit, ReciprocalSqrt(d, deviation_square)), usable);
        root = hn::Mul(root, hn::Sqrt(robust));
      }

      const V slope_x = hn::MulAdd(hn::Sub(l11, l01), ny.integral, hn::Mul(hn::Sub(l10, l00), up));
      const V slope_y = hn::MulAdd(hn::Sub(l11, l10), nx.integral, hn::Mul(hn::Sub(l01, l00), left));
      const V twist_slope = hn::Mul(cross, twist);
      const V by_ax = hn::Mul(hn::NegMulAdd(ax, twist_slope, hn::Mul(slope_x, nx.density)), root);
      const V by_ay = hn::Mul(hn::NegMulAdd(ay, twist_slope, hn::Mul(slope_y, ny.density)), root);

      float* row = rows + in_chunk * kRow * lanes;
      const auto put = [&](int index, V value) HWY_ATTR { hn::Store(value, d, row + index * lanes); };
      put(kShiftX, hn::Mul(by_ax, scale_x));
      put(kShiftY, hn::Mul(by_ay, scale_y));
      put(kBlur, hn::Neg(hn::Mul(hn::MulAdd(by_ax, ax, hn::Mul(by_ay, ay)), inverse_blur)));
      put(kLevel00, hn::Mul(w00, root));
      put(kLevel10, hn::Mul(w10, root));
      put(kLevel01, hn::Mul(w01, root));
      put(kLevel11, hn::Mul(w11, root));
      put(kResidual, hn::Mul(residual, root));
      if (++in_chunk == kChunk) {
        AddAllProducts(d, rows, kChunk, products);
        in_chunk = 0;
      }

      weight_sum = hn::Add(weight_sum, robust);
      // The noise is told from pixels that fit; a few that do not would swamp it.
      const V fits = hn::IfThenElse(off, zero, usable);
      const V square = hn::Mul(residual, residual);
      fit_square = hn::MulAdd(square, fits, fit_square);
      fit_count = hn::Add(fits, fit_count);
      if (tell_dark) {
        const V dark = hn::IfThenElseZero(hn::Lt(model, middle), fits);
        fit_light = hn::MulAdd(model, fits, fit_light);
        dark_square = hn::MulAdd(square, dark, dark_square);
        dark_light = hn::MulAdd(model, dark, dark_light);
        dark_count = hn::Add(dark, dark_count);
      }
    }
    AddAllProducts(d, rows, in_chunk, products);

    for (int product = 0; product < kProductSums; ++product)
      hn::StoreU(hn::Load(d, products + product * lanes), d, block.sum_data(product) + first);
    const auto finish = [&](LaneSum which, V value) HWY_ATTR { hn::StoreU(value, d, block.sum_data(which) + first); };
    finish(kWeight, weight_sum);
    finish(kDarkSquare, dark_square);
    finish(kDarkLight, dark_light);
    finish(kDarkCount, dark_count);
    finish(kLightSquare, hn::Sub(fit_square, dark_square));
    finish(kLightLight, hn::Sub(fit_light, dark_light));
    finish(kLightCount, hn::Sub(fit_count, dark_count));
  }
}

void EvenOut(const LightFall& fall, float saturation, LaneBlock& block) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V by_u = hn::Set(d, fall.by_u), by_v = hn::Set(d, fall.by_v), limit = hn::Set(d, saturation);
  const V by_uu = hn::Set(d, fall.by_uu), by_uv = hn::Set(d, fall.by_uv), by_vv = hn::Set(d, fall.by_vv);
  const V one = hn::Set(d, 1.0f), half = hn::Set(d, 0.5f), twelfth = hn::Set(d, 1.0f / 12);
  for (int first = 0; first < block.padded(); first += lanes) {
    int most = 0;
    for (int lane = first; lane < first + lanes; ++lane) most = most > block.count(lane) ? most : block.count(lane);
    // Also where no pixel stands: nobody looks there, and a test would cost more.
    for (int k = 0; k < most; ++k) {
      const std::size_t at = block.Place(first, k);
      const V light = hn::LoadU(d, block.light_data() + at);
      const V u = hn::LoadU(d, block.u_data() + at), v = hn::LoadU(d, block.v_data() + at);
      const V s =
          hn::MulAdd(u, hn::MulAdd(by_uu, u, hn::MulAdd(by_uv, v, by_u)), hn::Mul(v, hn::MulAdd(by_vv, v, by_v)));
      // e^−s by its Padé approximant.
      const V even = hn::MulAdd(hn::Mul(s, s), twelfth, one);
      const V scale = hn::Mul(hn::NegMulAdd(s, half, even), Reciprocal(d, hn::MulAdd(s, half, even)));
      hn::StoreU(hn::IfThenElse(hn::Lt(light, limit), hn::Mul(light, scale), light), d, block.light_data() + at);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>

namespace chequer {
namespace {

HWY_EXPORT(Accumulate);
HWY_EXPORT(EvenOut);

}  // namespace

void LaneBlock::Reset(int lanes, int pixels_per_lane) {
  lanes_ = lanes;
  padded_ = (lanes + kGroup - 1) / kGroup * kGroup;
  capacity_ = pixels_per_lane;
  const auto padded = static_cast<std::size_t>(padded_);
  // Values beyond a lane's count are multiplied by zero: they must be finite, whatever an earlier board left there is.
  pixels_.resize(std::max(pixels_.size(), 3 * padded * static_cast<std::size_t>(capacity_)));
  parameters_.assign(padded * kParameters, 1.0f);
  sums_.resize(padded * kLaneSums);
  counts_.assign(padded, 0);
}

void AccumulateLanes(const KernelInput& input, LaneBlock& block) { HWY_DYNAMIC_DISPATCH(Accumulate)(input, block); }

void EvenOutLanes(const LightFall& fall, float saturation, LaneBlock& block) {
  HWY_DYNAMIC_DISPATCH(EvenOut)(fall, saturation, block);
}

}  // namespace chequer
#endif  // HWY_ONCE
