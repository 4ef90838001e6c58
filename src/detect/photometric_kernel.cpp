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

/// Normal distribution: its density and its integral up to a.
struct Normal {
  V density, integral;
};

/// Abramowitz and Stegun 7.1.26 with the exponential shared; error below 1e-6.
Normal NormalAt(D d, V a) {
  a = hn::Max(hn::Min(a, hn::Set(d, 5.5f)), hn::Set(d, -5.5f));
  const V e = hn::Exp(d, hn::Mul(hn::Mul(a, a), hn::Set(d, -0.5f)));
  const V t = hn::Div(hn::Set(d, 1.0f), hn::MulAdd(hn::Abs(a), hn::Set(d, 0.3275911f * 0.70710678f), hn::Set(d, 1.0f)));
  V p = hn::MulAdd(hn::Set(d, 1.061405429f), t, hn::Set(d, -1.453152027f));
  p = hn::MulAdd(p, t, hn::Set(d, 1.421413741f));
  p = hn::MulAdd(p, t, hn::Set(d, -0.284496736f));
  p = hn::MulAdd(p, t, hn::Set(d, 0.254829592f));
  const V tail = hn::Mul(hn::Mul(hn::Mul(p, t), e), hn::Set(d, 0.5f));  // 1 − Φ(|a|)
  const V integral = hn::IfThenElse(hn::Lt(a, hn::Zero(d)), tail, hn::Sub(hn::Set(d, 1.0f), tail));
  return {hn::Mul(e, hn::Set(d, 0.39894228f)), integral};
}

void Accumulate(const KernelInput& input, LaneBlock& block) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int padded = block.padded();
  const V inverse_blur = hn::Set(d, 1.0f / input.blur_px);
  const V one = hn::Set(d, 1.0f);
  V h[9];
  for (int i = 0; i < 9; ++i) h[i] = hn::Set(d, input.board_from_plane[i]);

  for (int first = 0; first < padded; first += lanes) {
    int most = 0;
    HWY_ALIGN float counts[HWY_MAX_BYTES / sizeof(float)];
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

    V sums[kLaneSums];
    for (V& sum : sums) sum = hn::Zero(d);

    for (int k = 0; k < most; ++k) {
      const std::size_t at =
          static_cast<std::size_t>(k) * static_cast<std::size_t>(padded) + static_cast<std::size_t>(first);
      const auto inside = hn::Lt(hn::Set(d, static_cast<float>(k)), count);
      // Beyond a lane's count an earlier board's pixels may stand, which this homography may send to infinity.
      const V u = hn::IfThenElseZero(inside, hn::LoadU(d, block.u_data() + at));
      const V v = hn::IfThenElseZero(inside, hn::LoadU(d, block.v_data() + at));
      const V light = hn::LoadU(d, block.light_data() + at);

      const V w = hn::Div(one, hn::MulAdd(h[6], u, hn::MulAdd(h[7], v, h[8])));
      const V x = hn::MulSub(hn::MulAdd(h[0], u, hn::MulAdd(h[1], v, h[2])), w, corner_x);
      const V y = hn::MulSub(hn::MulAdd(h[3], u, hn::MulAdd(h[4], v, h[5])), w, corner_y);
      const V ax = hn::Mul(x, scale_x), ay = hn::Mul(y, scale_y);
      const Normal nx = NormalAt(d, ax), ny = NormalAt(d, ay);

      // Cells' shares. Edges that are not square to each other blur together: the shares are those of a bivariate
      // normal distribution, to first order in the correlation.
      const V twist = hn::Mul(correlation, hn::Mul(nx.density, ny.density));
      const V left = hn::Sub(one, nx.integral), up = hn::Sub(one, ny.integral);
      const V w00 = hn::MulAdd(left, up, twist), w10 = hn::Sub(hn::Mul(nx.integral, up), twist);
      const V w01 = hn::Sub(hn::Mul(left, ny.integral), twist), w11 = hn::MulAdd(nx.integral, ny.integral, twist);
      const V model = hn::MulAdd(w00, l00, hn::MulAdd(w10, l10, hn::MulAdd(w01, l01, hn::Mul(w11, l11))));

      // A saturated pixel agrees with every model that saturates too.
      const auto agrees = hn::And(hn::Ge(light, hn::Set(d, input.saturation)), hn::Ge(model, light));
      const V usable = hn::IfThenElse(hn::AndNot(agrees, inside), one, hn::Zero(d));
      const V residual = hn::Mul(hn::Sub(light, model), usable);

      const V variance = hn::MulAdd(noise_slope, hn::Max(model, hn::Zero(d)), noise_floor);
      V weight = hn::Div(usable, variance);
      const V square = hn::Mul(residual, residual);
      const V deviation = hn::Sqrt(hn::Mul(square, weight));
      const V limit = hn::Set(d, input.robust_limit);
      const V robust = hn::IfThenElse(hn::Gt(deviation, limit), hn::Div(limit, deviation), one);
      weight = hn::Mul(weight, robust);

      const V slope_x = hn::MulAdd(hn::Sub(l11, l01), ny.integral, hn::Mul(hn::Sub(l10, l00), up));
      const V slope_y = hn::MulAdd(hn::Sub(l11, l10), nx.integral, hn::Mul(hn::Sub(l01, l00), left));
      const V twist_slope = hn::Mul(cross, twist);
      const V by_ax = hn::MulAdd(slope_x, nx.density, hn::Neg(hn::Mul(ax, twist_slope)));
      const V by_ay = hn::MulAdd(slope_y, ny.density, hn::Neg(hn::Mul(ay, twist_slope)));

      V j[kLaneParameters];
      j[kShiftX] = hn::Mul(by_ax, scale_x);
      j[kShiftXAlongY] = hn::Mul(j[kShiftX], y);
      j[kShiftY] = hn::Mul(by_ay, scale_y);
      j[kShiftYAlongX] = hn::Mul(j[kShiftY], x);
      j[kBlur] = hn::Neg(hn::Mul(hn::MulAdd(by_ax, ax, hn::Mul(by_ay, ay)), inverse_blur));
      j[kLevel00] = w00;
      j[kLevel10] = w10;
      j[kLevel01] = w01;
      j[kLevel11] = w11;
      int sum = 0;
      for (int a = 0; a < kLaneParameters; ++a) {
        const V weighted = hn::Mul(j[a], weight);
        for (int b = a; b < kLaneParameters; ++b, ++sum) sums[sum] = hn::MulAdd(weighted, j[b], sums[sum]);
        sums[kGradient + a] = hn::MulAdd(weighted, residual, sums[kGradient + a]);
      }
      sums[kChiSquare] = hn::MulAdd(weight, square, sums[kChiSquare]);
      sums[kWeight] = hn::MulAdd(robust, usable, sums[kWeight]);
      // The noise is told from pixels that fit; a few that do not would swamp it.
      const V fits = hn::IfThenElse(hn::Gt(deviation, limit), hn::Zero(d), usable);
      const V dark = hn::IfThenElse(hn::Lt(model, middle), fits, hn::Zero(d));
      const V bright = hn::Sub(fits, dark);
      sums[kDarkSquare] = hn::MulAdd(square, dark, sums[kDarkSquare]);
      sums[kDarkLight] = hn::MulAdd(model, dark, sums[kDarkLight]);
      sums[kDarkCount] = hn::Add(dark, sums[kDarkCount]);
      sums[kLightSquare] = hn::MulAdd(square, bright, sums[kLightSquare]);
      sums[kLightLight] = hn::MulAdd(model, bright, sums[kLightLight]);
      sums[kLightCount] = hn::Add(bright, sums[kLightCount]);
    }
    for (int i = 0; i < kLaneSums; ++i) hn::StoreU(sums[i], d, block.sum_data(i) + first);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace chequer {
namespace {

HWY_EXPORT(Accumulate);

/// Lanes of the widest vectors (AVX-512).
constexpr int kWidest = 16;

}  // namespace

void LaneBlock::Reset(int lanes, int samples_per_lane) {
  lanes_ = lanes;
  padded_ = (lanes + kWidest - 1) / kWidest * kWidest;
  capacity_ = samples_per_lane;
  const auto padded = static_cast<std::size_t>(padded_);
  const std::size_t samples = padded * static_cast<std::size_t>(capacity_);
  // Values beyond a lane's count are multiplied by zero: they must be finite, whatever an earlier board left there is.
  if (u_.size() < samples) {
    u_.resize(samples);
    v_.resize(samples);
    light_.resize(samples);
  }
  parameters_.assign(padded * kParameters, 1.0f);
  sums_.resize(padded * kLaneSums);
  counts_.assign(padded, 0);
}

void AccumulateLanes(const KernelInput& input, LaneBlock& block) { HWY_DYNAMIC_DISPATCH(Accumulate)(input, block); }

}  // namespace chequer
#endif  // HWY_ONCE
