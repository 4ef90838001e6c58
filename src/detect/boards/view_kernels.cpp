#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/boards/view_kernels.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include <bit>
#include <cstddef>
#include <cstdint>

#ifndef CHEQUER_DETECT_VIEW_KERNELS
#define CHEQUER_DETECT_VIEW_KERNELS
namespace chequer {
namespace affine_view {

/// Bits behind the point of coordinates.
constexpr int kBits = 16;
/// Pixels of a view that are made together.
constexpr int kTogether = 16;

/// A point or a step in the plane, in fixed point.
struct FixedPoint {
  int x, y;
};

/// What a view is of.
struct Source {
  const std::uint8_t* pixels;
  std::ptrdiff_t stride;
  FixedPoint last;  ///< the last point that has four pixels around it
};

/// A row of a view: each pixel the mean of some samples.
struct Row {
  FixedPoint first;     ///< sample of the first pixel
  FixedPoint right;     ///< from a pixel to the next
  FixedPoint tap_step;  ///< from a sample to the next
  int taps;
};

}  // namespace affine_view
}  // namespace chequer
#endif  // CHEQUER_DETECT_VIEW_KERNELS

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DI = hn::CappedTag<std::int32_t, affine_view::kTogether>;
using VI = hn::Vec<DI>;

/// The values of 256 times the plane at some points, between the four pixels around each.
HWY_INLINE VI Sample(const affine_view::Source& source, VI x, VI y) {
  using affine_view::kBits;
  const DI d;
  const hn::Rebind<std::uint8_t, DI> bytes;
  constexpr std::size_t kMost = affine_view::kTogether;
  const std::size_t lanes = hn::Lanes(d);
  const VI zero = hn::Zero(d), part = hn::Set(d, 255);
  x = hn::Min(hn::Max(x, zero), hn::Set(d, source.last.x));
  y = hn::Min(hn::Max(y, zero), hn::Set(d, source.last.y));
  const VI row = hn::Mul(hn::ShiftRight<kBits>(y), hn::Set(d, static_cast<int>(source.stride)));
  HWY_ALIGN int at[kMost];
  hn::Store(hn::Add(row, hn::ShiftRight<kBits>(x)), d, at);
  HWY_ALIGN std::uint8_t pixels[4][kMost];
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    const std::uint8_t *above = source.pixels + at[lane], *below = above + source.stride;
    pixels[0][lane] = above[0], pixels[1][lane] = above[1];
    pixels[2][lane] = below[0], pixels[3][lane] = below[1];
  }
  const auto pixel = [&](int k) HWY_ATTR { return hn::PromoteTo(d, hn::Load(bytes, pixels[k])); };
  const VI part_x = hn::And(hn::ShiftRight<kBits - 8>(x), part), part_y = hn::And(hn::ShiftRight<kBits - 8>(y), part);
  const VI a = pixel(0), b = pixel(2);
  const VI top = hn::Add(hn::ShiftLeft<8>(a), hn::Mul(part_x, hn::Sub(pixel(1), a))),
           bottom = hn::Add(hn::ShiftLeft<8>(b), hn::Mul(part_x, hn::Sub(pixel(3), b)));
  return hn::ShiftRight<8>(hn::Add(hn::ShiftLeft<8>(top), hn::Mul(part_y, hn::Sub(bottom, top))));
}

/// Makes `count` pixels; may write into the row's tail.
void ViewRow(const affine_view::Source& source, const affine_view::Row& row, int count, std::uint8_t* out) {
  const DI d;
  const hn::RebindToUnsigned<DI> du;
  const hn::Rebind<std::uint8_t, DI> bytes;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto scale = hn::Set(du, static_cast<std::uint32_t>((1 << 16) / row.taps));
  const auto half = hn::Set(du, std::uint32_t{1} << 23);
  VI x = hn::Add(hn::Set(d, row.first.x), hn::Mul(hn::Iota(d, 0), hn::Set(d, row.right.x))),
     y = hn::Add(hn::Set(d, row.first.y), hn::Mul(hn::Iota(d, 0), hn::Set(d, row.right.y)));
  const VI next_x = hn::Set(d, lanes * row.right.x), next_y = hn::Set(d, lanes * row.right.y);
  const VI tap_x = hn::Set(d, row.tap_step.x), tap_y = hn::Set(d, row.tap_step.y);
  for (int i = 0; i < count; i += lanes) {
    VI sum = hn::Zero(d), at_x = x, at_y = y;
    for (int tap = 0; tap < row.taps; ++tap) {
      sum = hn::Add(sum, Sample(source, at_x, at_y));
      at_x = hn::Add(at_x, tap_x);
      at_y = hn::Add(at_y, tap_y);
    }
    const auto mean = hn::ShiftRight<24>(hn::Add(hn::Mul(hn::BitCast(du, sum), scale), half));
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(d, mean)), bytes, out + i);
    x = hn::Add(x, next_x);
    y = hn::Add(y, next_y);
  }
}

/// out[i] = the mean of in[i] to in[i + width − 1], rounded; may write a vector too far.
void MeanOfRow(const std::uint8_t* in, int count, int width, std::uint8_t* out) {
  const hn::ScalableTag<std::uint16_t> d;
  const hn::RebindToSigned<decltype(d)> signed_d;
  const hn::Rebind<std::uint8_t, decltype(d)> bytes;
  const int lanes = static_cast<int>(hn::Lanes(d));
  // sum / width = sum · inverse >> (16 + shift), exactly: width is odd, and sum · width < 2^(16 + shift), as it is at
  // most 15.
  const int shift = static_cast<int>(std::bit_width(static_cast<unsigned>(width))) - 1;
  const auto inverse = hn::Set(d, static_cast<std::uint16_t>((1 << (16 + shift)) / width + 1));
  const auto half = hn::Set(d, static_cast<std::uint16_t>(width / 2));
  for (int i = 0; i < count; i += lanes) {
    auto sum = half;
    for (int k = 0; k < width; ++k) sum = hn::Add(sum, hn::PromoteTo(d, hn::LoadU(bytes, in + i + k)));
    const auto mean = hn::ShiftRightSame(hn::MulHigh(sum, inverse), shift);
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(signed_d, mean)), bytes, out + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <algorithm>
#include <cmath>

#include "detect/boards/view_kernels.h"

namespace chequer {
namespace {

HWY_EXPORT(ViewRow);
HWY_EXPORT(MeanOfRow);

using affine_view::FixedPoint, affine_view::kBits;

/// Between the samples that make up a pixel, px of the plane (a guess).
constexpr float kTapPx = 1.5f;

FixedPoint Fixed(const Eigen::Vector2f& p) {
  return {static_cast<int>(std::lround(p.x() * (1 << kBits))), static_cast<int>(std::lround(p.y() * (1 << kBits)))};
}

}  // namespace

void ViewPlane(const BytePlane& plane, const Eigen::Vector2f& middle, const Eigen::Matrix2f& plane_by_view, int side,
               BytePlane& view) {
  view.Resize(side, side);
  // Between pixels, a tap takes in two of them.
  const int taps = std::clamp(static_cast<int>(std::lround(plane_by_view.col(0).norm() / kTapPx)), 1, 8);
  // The first of a pixel's taps, one pixel's step to the right, and the step from tap to tap.
  const Eigen::Vector2f tap = plane_by_view.col(0) / static_cast<float>(taps);
  const float half = 0.5f * static_cast<float>(side - 1);
  const affine_view::Source source{
      plane.row(0), plane.stride(), {((plane.width() - 1) << kBits) - 1, ((plane.height() - 1) << kBits) - 1}};
  affine_view::Row row{.first = {}, .right = Fixed(plane_by_view.col(0)), .tap_step = Fixed(tap), .taps = taps};
  for (int y = 0; y < side; ++y) {
    row.first = Fixed(middle + plane_by_view * Eigen::Vector2f(-half, static_cast<float>(y) - half) -
                      0.5f * static_cast<float>(taps - 1) * tap);
    HWY_DYNAMIC_DISPATCH(ViewRow)(source, row, side, view.row(y));
  }
}

void SmoothRows(int width, BytePlane& plane, std::vector<std::uint8_t>& scratch) {
  const int count = plane.width(), reach = width / 2;
  scratch.resize(static_cast<std::size_t>(count + 2 * reach + BytePlane::kTail));
  std::uint8_t* const middle = scratch.data() + reach;
  for (int y = 0; y < plane.height(); ++y)
    for (int pass = 0; pass < 2; ++pass) {
      std::uint8_t* const row = plane.row(y);
      std::copy_n(row, count, middle);
      std::fill_n(scratch.data(), reach, row[0]);
      std::fill_n(middle + count, reach, row[count - 1]);
      HWY_DYNAMIC_DISPATCH(MeanOfRow)(scratch.data(), count, width, row);
    }
}

}  // namespace chequer
#endif  // HWY_ONCE
