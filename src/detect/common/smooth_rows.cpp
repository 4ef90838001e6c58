#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/common/smooth_rows.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include <bit>
#include <cstdint>

#include "detect/common/smooth_rows.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

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

namespace chequer {
namespace {

HWY_EXPORT(MeanOfRow);

}  // namespace

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
