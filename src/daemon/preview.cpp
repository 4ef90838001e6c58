#include "daemon/preview.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/jpeg.h"
#include "core/crop.h"
#include "core/yuv_samples.h"

namespace chequer {
namespace {

/// Good enough to see a marker's cells by, a third of the bytes of 90.
constexpr int kQuality = 75;

/// Two columns (or rows) of the frame that make one of the picture.
struct Pair {
  int first = 0, second = 0;
};

std::vector<Pair> PairsOf(int from, int to) {
  std::vector<Pair> pairs(static_cast<std::size_t>(to));
  const double scale = static_cast<double>(from) / to;
  for (int i = 0; i < to; ++i) {
    const auto at = [&](double part) { return std::clamp(static_cast<int>((i + part) * scale), 0, from - 1); };
    pairs[static_cast<std::size_t>(i)] = {at(0.25), at(0.75)};
  }
  return pairs;
}

std::uint8_t Mean(int a, int b) { return static_cast<std::uint8_t>((a + b) / 2); }
std::uint8_t Clip(int value) { return static_cast<std::uint8_t>(std::clamp(value, 0, 255)); }

void ScalePacked(const ImageView& image, const std::vector<Pair>& columns, const std::vector<Pair>& rows, int channels,
                 std::uint8_t* out) {
  for (const Pair& row : rows) {
    const std::uint8_t* upper = image.row(row.first);
    const std::uint8_t* lower = image.row(row.second);
    for (const Pair& column : columns)
      for (int c = 0; c < channels; ++c)
        *out++ = Mean(upper[channels * column.first + c], lower[channels * column.second + c]);
  }
}

/// Bayer: of each pair's first pixel the four of its block, which hold all colours.
void ScaleBayer(const ImageView& image, const std::vector<Pair>& columns, const std::vector<Pair>& rows,
                std::uint8_t* out) {
  const bool red_row_first = image.format() == PixelFormat::kBayerRg8 || image.format() == PixelFormat::kBayerGr8;
  const bool green_first = image.format() == PixelFormat::kBayerGr8 || image.format() == PixelFormat::kBayerGb8;
  for (const Pair& row : rows) {
    const int y = std::min(row.first & ~1, std::max(0, image.height() - 2));
    const std::uint8_t* upper = image.row(y);
    const std::uint8_t* lower = image.row(std::min(y + 1, image.height() - 1));
    for (const Pair& column : columns) {
      const int x = std::min(column.first & ~1, std::max(0, image.width() - 2));
      const int next = std::min(x + 1, image.width() - 1);
      // Of the block, the two greens lie on one diagonal, the other colours on the other.
      const int of_upper = green_first ? upper[next] : upper[x], of_lower = green_first ? lower[x] : lower[next];
      const int green = green_first ? Mean(upper[x], lower[next]) : Mean(upper[next], lower[x]);
      *out++ = static_cast<std::uint8_t>(red_row_first ? of_lower : of_upper);
      *out++ = static_cast<std::uint8_t>(green);
      *out++ = static_cast<std::uint8_t>(red_row_first ? of_upper : of_lower);
    }
  }
}

/// YUV as BT.601, in 16 bits behind the point.
void ScaleYuv(const ImageView& image, const std::vector<Pair>& columns, const std::vector<Pair>& rows,
              std::uint8_t* out) {
  const YuvLayout layout = LayoutOfYuv(image.format());
  const bool limited = image.yuv_range() == YuvRange::kLimited;
  const int luma = limited ? 76309 : 65536, floor = limited ? 16 : 0;
  const int scale = limited ? 74606 : 65536;  // of chroma: 255 / 224
  const auto chroma = [&](double weight) { return static_cast<int>(weight * scale); };
  const int red_v = chroma(1.402), green_u = chroma(0.344136), green_v = chroma(0.714136), blue_u = chroma(1.772);
  const auto row_of = [&](std::size_t channel, int y) {
    return image.row(y, layout.channels[channel].plane) + layout.channels[channel].first;
  };
  for (const Pair& row : rows) {
    const std::uint8_t* upper = row_of(0, row.first);
    const std::uint8_t* lower = row_of(0, row.second);
    const std::uint8_t* u_row = row_of(1, row.first / layout.chroma_height);
    const std::uint8_t* v_row = row_of(2, row.first / layout.chroma_height);
    const int y_step = layout.channels[0].step, u_step = layout.channels[1].step, v_step = layout.channels[2].step;
    for (const Pair& column : columns) {
      const int at = column.first / layout.chroma_width;
      const int y = (Mean(upper[y_step * column.first], lower[y_step * column.second]) - floor) * luma + 32768;
      const int u = u_row[u_step * at] - 128, v = v_row[v_step * at] - 128;
      *out++ = Clip((y + blue_u * u) >> 16);
      *out++ = Clip((y - green_u * u - green_v * v) >> 16);
      *out++ = Clip((y + red_v * v) >> 16);
    }
  }
}

/// Values as a screen shows them.
void ShowAsSrgb(const ToneCurve& tone_curve, std::span<std::uint8_t> values) {
  if (tone_curve.is_srgb() || std::abs(tone_curve.gamma() - 2.2) < 0.3) return;
  const std::array<float, 256> light = tone_curve.LinearTable();
  std::array<std::uint8_t, 256> shown{};
  for (std::size_t i = 0; i < 256; ++i)
    shown[i] =
        static_cast<std::uint8_t>(std::lround(255 * ToneCurve::Srgb().FromLinear(static_cast<double>(light[i]))));
  for (std::uint8_t& value : values) value = shown[value];
}

PixelFormat ScaledFormat(PixelFormat format) {
  return format == PixelFormat::kMono8 || format == PixelFormat::kRgb8 ? format : PixelFormat::kBgr8;
}

}  // namespace

Preview PreviewMaker::Make(const ImageView& image, const PixelRegion& wanted, int width) {
  PixelRegion region = wanted.IsWhole() ? PixelRegion{0, 0, image.width(), image.height()} : wanted;
  const ImageView part = Crop(image, region.x, region.y, region.width, region.height);
  if (part.empty()) return {};
  const int columns = std::min(width, part.width());
  const int rows =
      std::max(1, static_cast<int>(std::lround(static_cast<double>(part.height()) * columns / part.width())));
  const PixelFormat format = ScaledFormat(part.format());
  if (scaled_.width() != columns || scaled_.height() != rows || scaled_.format() != format)
    scaled_ = Image(format, columns, rows);
  const std::vector<Pair> x = PairsOf(part.width(), columns), y = PairsOf(part.height(), rows);
  std::uint8_t* out = scaled_.bytes().data();
  if (IsYuv(part.format()))
    ScaleYuv(part, x, y, out);
  else if (IsBayer(part.format()))
    ScaleBayer(part, x, y, out);
  else
    ScalePacked(part, x, y, part.format() == PixelFormat::kMono8 ? 1 : 3, out);
  ShowAsSrgb(part.tone_curve(), scaled_.bytes());
  return {region, columns, rows, JpegFromImage(scaled_.view(), {.quality = kQuality, .chroma = ChromaSharing::k420})};
}

}  // namespace chequer
