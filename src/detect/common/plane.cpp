#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/common/plane.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include <cstring>

#include "detect/common/plane.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Rows of BytePlane have a tail, so stores may run over the width; loads from the image may not, hence the rests.

#if HWY_TARGET != HWY_SCALAR
using DTriples = hn::CappedTag<std::uint8_t, 32>;
using VTriples = hn::Vec<DTriples>;

/// Every third byte, from the first on, of three vectors that follow each other.
HWY_INLINE VTriples EveryThird(VTriples a, VTriples b, VTriples c) {
  // Of 48 bytes, as they lie in blocks of 16; the others become zero.
  constexpr std::uint8_t kNone = 0x80;
  alignas(16) static constexpr std::uint8_t kPlaces[3][16] = {
      {0, 3, 6, 9, 12, 15, kNone, kNone, kNone, kNone, kNone, kNone, kNone, kNone, kNone, kNone},
      {kNone, kNone, kNone, kNone, kNone, kNone, 2, 5, 8, 11, 14, kNone, kNone, kNone, kNone, kNone},
      {kNone, kNone, kNone, kNone, kNone, kNone, kNone, kNone, kNone, kNone, kNone, 1, 4, 7, 10, 13}};
  const DTriples d;
  VTriples blocks[3] = {a, b, c};
  // Of two blocks a vector, the first, second and third of either 48 bytes.
  if constexpr (hn::MaxLanes(DTriples()) == 32) {
    blocks[0] = hn::ConcatUpperLower(d, b, a);
    blocks[1] = hn::ConcatLowerUpper(d, c, a);
    blocks[2] = hn::ConcatUpperLower(d, c, b);
  }
  const auto third = [&](int block)
                         HWY_ATTR { return hn::TableLookupBytesOr0(blocks[block], hn::LoadDup128(d, kPlaces[block])); };
  return hn::Or(hn::Or(third(0), third(1)), third(2));
}
#endif

/// (first + second) / 2 of the three interleaved bytes; the third is left out.
void InterleavedRow(const std::uint8_t* in, int width, int first, std::uint8_t* out) {
#if HWY_TARGET != HWY_SCALAR
  int x = 0;
  const DTriples d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  // The two lie side by side: the mean of each byte and the next has theirs, and needs one more byte to load.
  const auto means = [&](const std::uint8_t* at)
                         HWY_ATTR { return hn::AverageRound(hn::LoadU(d, at), hn::LoadU(d, at + 1)); };
  const std::uint8_t* pair = in + (first == 0 ? 0 : 1);
  for (; x + lanes < width; x += lanes, pair += 3 * lanes)
    hn::StoreU(EveryThird(means(pair), means(pair + lanes), means(pair + 2 * lanes)), d, out + x);
  // The rest from a copy, which has bytes to follow.
  std::uint8_t rest[3 * hn::MaxLanes(DTriples()) + 2] = {};
  std::memcpy(rest, in + 3 * x, static_cast<std::size_t>(3 * (width - x)));
  pair = rest + (first == 0 ? 0 : 1);
  hn::StoreU(EveryThird(means(pair), means(pair + lanes), means(pair + 2 * lanes)), d, out + x);
#else
  for (int x = 0; x < width; ++x) out[x] = static_cast<std::uint8_t>((in[3 * x + 1] + in[3 * x + first] + 1) / 2);
#endif
}

/// Even (offset 0) or odd (offset 1) bytes of an interleaved row.
void EveryOtherRow(const std::uint8_t* in, int width, int offset, std::uint8_t* out) {
  const hn::ScalableTag<std::uint8_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  int x = 0;
  for (; x + lanes <= width; x += lanes) {
    hn::Vec<decltype(d)> even, odd;
    hn::LoadInterleaved2(d, in + 2 * x, even, odd);
    hn::StoreU(offset == 0 ? even : odd, d, out + x);
  }
  for (; x < width; ++x) out[x] = in[2 * x + offset];
}

/// Windows of 2 × 2 pixels over a row with red and a row with blue: ¼ R + ¼ G (red row) + ½ G (blue row).
/// @param green_first whether the blue row's first pixel is green.
void BayerRow(const std::uint8_t* red_row, const std::uint8_t* blue_row, int width, bool green_first,
              std::uint8_t* out) {
  const hn::ScalableTag<std::uint8_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto parity = hn::And(hn::Iota(d, 0), hn::Set(d, 1));
  // Where the window's left pixel of the blue row is green, for vectors that begin at an even pixel, or an odd one.
  const hn::Mask<decltype(d)> left_is_green[2] = {hn::Eq(parity, hn::Set(d, green_first ? 0 : 1)),
                                                  hn::Eq(parity, hn::Set(d, green_first ? 1 : 0))};
  const auto window = [&](int x) HWY_ATTR {
    const auto red_and_green = hn::AverageRound(hn::LoadU(d, red_row + x), hn::LoadU(d, red_row + x + 1));
    const auto green = hn::IfThenElse(left_is_green[x & 1], hn::LoadU(d, blue_row + x), hn::LoadU(d, blue_row + x + 1));
    hn::StoreU(hn::AverageRound(red_and_green, green), d, out + x);
  };
  const int past = width - 1;
  // A vector of one lane would have but one parity.
  if (lanes > 1 && past >= lanes) {
    for (int x = 0; x + lanes <= past; x += lanes) window(x);
    window(past - lanes);
    return;
  }
  for (int x = 0; x < past; ++x) {
    const int green = blue_row[((x & 1) == 0) == green_first ? x : x + 1];
    out[x] = static_cast<std::uint8_t>(((red_row[x] + red_row[x + 1] + 1) / 2 + green + 1) / 2);
  }
}

void HalveRow(const std::uint8_t* top, const std::uint8_t* bottom, int half_width, std::uint8_t* out) {
  const hn::ScalableTag<std::uint8_t> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  // Reads run into the rows' tails at most.
  for (int x = 0; x < half_width; x += lanes) {
    hn::Vec<decltype(d)> a, b, c, e;
    hn::LoadInterleaved2(d, top + 2 * x, a, b);
    hn::LoadInterleaved2(d, bottom + 2 * x, c, e);
    hn::StoreU(hn::AverageRound(hn::AverageRound(a, e), hn::AverageRound(b, c)), d, out + x);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace chequer {
namespace {

HWY_EXPORT(InterleavedRow);
HWY_EXPORT(EveryOtherRow);
HWY_EXPORT(BayerRow);
HWY_EXPORT(HalveRow);

void FillFromBayer(const ImageView& image, int first, int past, BytePlane& plane) {
  const PixelFormat format = image.format();
  const bool first_row_has_red = format == PixelFormat::kBayerRg8 || format == PixelFormat::kBayerGr8;
  // The rows with blue are G B for RG and GB, B G for GR and BG.
  const bool green_first = format == PixelFormat::kBayerRg8 || format == PixelFormat::kBayerGb8;
  for (int y = first; y < past; ++y) {
    const bool red_is_top = (y % 2 == 0) == first_row_has_red;
    HWY_DYNAMIC_DISPATCH(BayerRow)
    (image.row(red_is_top ? y : y + 1), image.row(red_is_top ? y + 1 : y), image.width(), green_first, plane.row(y));
  }
}

}  // namespace

void BytePlane::Resize(int width, int height) {
  width_ = width;
  height_ = height;
  stride_ = (width + kTail + 63) / 64 * 64;
  // One row more: vectors over the end of the last row.
  bytes_.Resize(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height + 1));
}

void StartDetectionPlane(const ImageView& image, DetectionPlane& out) {
  // A window of 2 × 2 pixels lies half a pixel on from its first.
  const int less = IsBayer(image.format()) ? 1 : 0;
  out.offset_px = 0.5f * static_cast<float>(less);
  const bool empty = image.width() < 2 || image.height() < 2;
  out.plane.Resize(empty ? 0 : image.width() - less, empty ? 0 : image.height() - less);
}

void BuildDetectionPlane(const ImageView& image, DetectionPlane& out) {
  StartDetectionPlane(image, out);
  FillDetectionPlane(image, 0, out.plane.height(), out);
}

void FillDetectionPlane(const ImageView& image, int first, int past, DetectionPlane& out) {
  if (IsBayer(image.format())) return FillFromBayer(image, first, past, out.plane);
  for (int y = first; y < past; ++y) {
    const std::uint8_t* in = image.row(y);
    std::uint8_t* row = out.plane.row(y);
    switch (image.format()) {
      case PixelFormat::kBgr8: HWY_DYNAMIC_DISPATCH(InterleavedRow)(in, image.width(), 2, row); break;
      case PixelFormat::kRgb8: HWY_DYNAMIC_DISPATCH(InterleavedRow)(in, image.width(), 0, row); break;
      case PixelFormat::kYuyv: HWY_DYNAMIC_DISPATCH(EveryOtherRow)(in, image.width(), 0, row); break;
      case PixelFormat::kUyvy: HWY_DYNAMIC_DISPATCH(EveryOtherRow)(in, image.width(), 1, row); break;
      default: std::memcpy(row, in, static_cast<std::size_t>(image.width())); break;
    }
  }
}

void HalveRows(const BytePlane& full, int first, int past, BytePlane& half) {
  for (int y = first; y < past; ++y)
    HWY_DYNAMIC_DISPATCH(HalveRow)(full.row(2 * y), full.row(2 * y + 1), half.width(), half.row(y));
}

}  // namespace chequer
#endif  // HWY_ONCE
