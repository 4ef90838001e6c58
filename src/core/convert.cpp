#include "core/convert.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "chequer/check.h"
#include "core/yuv_samples.h"

namespace chequer {
namespace {

constexpr int kBlue = 0, kGreen = 1, kRed = 2;

std::uint8_t Clipped(float value) { return static_cast<std::uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f)); }

// Full-range value of a sample of some range, and back. Exact for full range.
float Expanded(std::uint8_t sample, bool luma, YuvRange range) {
  const float value = sample;
  if (range == YuvRange::kFull) return value;
  return luma ? (value - 16) * 255 / 219 : 128 + (value - 128) * 255 / 224;
}

float Compressed(float value, bool luma, YuvRange range) {
  if (range == YuvRange::kFull) return value;
  return luma ? 16 + value * 219 / 255 : 128 + (value - 128) * 224 / 255;
}

/// Which colour (kBlue …) a pixel of a Bayer format sees.
int BayerColour(PixelFormat format, int x, int y) {
  const bool odd_x = x % 2 != 0, odd_y = y % 2 != 0;
  switch (format) {
    case PixelFormat::kBayerRg8: return odd_x != odd_y ? kGreen : odd_y ? kBlue : kRed;
    case PixelFormat::kBayerBg8: return odd_x != odd_y ? kGreen : odd_y ? kRed : kBlue;
    case PixelFormat::kBayerGr8: return odd_x == odd_y ? kGreen : odd_y ? kBlue : kRed;
    case PixelFormat::kBayerGb8: return odd_x == odd_y ? kGreen : odd_y ? kRed : kBlue;
    default: FailCheck("IsBayer(format)", __FILE__, __LINE__, "not a Bayer format");
  }
}

/// One colour at a pixel: its own value, or the mean of those neighbours that see it.
std::uint8_t DemosaicPixel(const ImageView& raw, int x, int y, int colour) {
  if (BayerColour(raw.format(), x, y) == colour) return raw.row(y)[x];
  int sum = 0, count = 0;
  for (int j = std::max(y - 1, 0); j <= std::min(y + 1, raw.height() - 1); ++j)
    for (int i = std::max(x - 1, 0); i <= std::min(x + 1, raw.width() - 1); ++i)
      if (BayerColour(raw.format(), i, j) == colour) sum += raw.row(j)[i], ++count;
  return count == 0 ? std::uint8_t{0} : static_cast<std::uint8_t>((sum + count / 2) / count);
}

/// Full-range Y, U, V of any pixel of a YUV image.
class YuvReader {
 public:
  explicit YuvReader(const ImageView& image) : image_(image), layout_(LayoutOfYuv(image.format())) {}

  std::array<float, 3> At(int x, int y) const {
    const int column = x / layout_.chroma_width, row = y / layout_.chroma_height;
    return {Sample(0, x, y), Sample(1, column, row), Sample(2, column, row)};
  }

 private:
  float Sample(std::size_t channel, int column, int row) const {
    const YuvChannel& c = layout_.channels[channel];
    return Expanded(image_.row(row, c.plane)[c.first + c.step * column], channel == 0, image_.yuv_range());
  }
  const ImageView& image_;
  YuvLayout layout_;
};

/// Full-range Y, U, V of any pixel of a BGR8 image.
class BgrReader {
 public:
  explicit BgrReader(const ImageView& image) : image_(image) {}
  std::array<float, 3> At(int x, int y) const { return YuvFromBgr(image_.row(y) + 3 * x); }

 private:
  const ImageView& image_;
};

/// The packed bytes of an image that is being made.
struct YuvWriter {
  YuvWriter(Image& image, YuvRange yuv_range) : layout(LayoutOfYuv(image.format())), range(yuv_range) {
    const auto shapes = PlaneShapes(image.format(), image.width(), image.height());
    std::uint8_t* next = image.bytes().data();
    for (std::size_t i = 0; i < planes.size(); ++i) {
      planes[i] = next;
      row_bytes[i] = shapes[i].row_bytes;
      next += static_cast<std::ptrdiff_t>(shapes[i].row_bytes) * shapes[i].rows;
    }
  }
  void Set(std::size_t channel, int column, int row, float value) {
    const YuvChannel& c = layout.channels[channel];
    const auto plane = static_cast<std::size_t>(c.plane);
    planes[plane][row_bytes[plane] * row + c.first + c.step * column] = Clipped(Compressed(value, channel == 0, range));
  }
  YuvLayout layout;
  YuvRange range;
  std::array<std::uint8_t*, 3> planes{};
  std::array<std::ptrdiff_t, 3> row_bytes{};
};

template <typename Reader>
Image WriteYuv(const Reader& reader, const ImageView& like, PixelFormat format, YuvRange range) {
  Image out(format, like.width(), like.height(), like.tone_curve(), range);
  YuvWriter writer(out, range);
  const int block_width = writer.layout.chroma_width, block_height = writer.layout.chroma_height;
  for (int y0 = 0; y0 < out.height(); y0 += block_height)
    for (int x0 = 0; x0 < out.width(); x0 += block_width) {
      float u = 0, v = 0, count = 0;
      for (int y = y0; y < std::min(y0 + block_height, out.height()); ++y)
        for (int x = x0; x < std::min(x0 + block_width, out.width()); ++x) {
          const auto yuv = reader.At(x, y);
          writer.Set(0, x, y, yuv[0]);
          u += yuv[1], v += yuv[2], ++count;
        }
      writer.Set(1, x0 / block_width, y0 / block_height, u / count);
      writer.Set(2, x0 / block_width, y0 / block_height, v / count);
    }
  return out;
}

template <typename Reader>
Image WriteLuma(const Reader& reader, const ImageView& like) {
  Image out(PixelFormat::kMono8, like.width(), like.height(), like.tone_curve());
  std::uint8_t* to = out.bytes().data();
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x) *to++ = Clipped(reader.At(x, y)[0]);
  return out;
}

Image Copy(const ImageView& image) {
  Image out(image.format(), image.width(), image.height(), image.tone_curve(), image.yuv_range());
  const auto shapes = PlaneShapes(image.format(), image.width(), image.height());
  std::uint8_t* to = out.bytes().data();
  for (int plane = 0; plane < 3; ++plane) {
    const PlaneShape& shape = shapes[static_cast<std::size_t>(plane)];
    for (int y = 0; y < shape.rows; ++y, to += shape.row_bytes)
      std::memcpy(to, image.row(y, plane), static_cast<std::size_t>(shape.row_bytes));
  }
  return out;
}

Image SwapRedAndBlue(const ImageView& image, PixelFormat format) {
  Image out(format, image.width(), image.height(), image.tone_curve());
  std::uint8_t* to = out.bytes().data();
  for (int y = 0; y < image.height(); ++y)
    for (const std::uint8_t* from = image.row(y); from != image.row(y) + 3 * image.width(); from += 3, to += 3)
      to[0] = from[2], to[1] = from[1], to[2] = from[0];
  return out;
}

Image Mosaic(const ImageView& bgr, PixelFormat format) {
  Image out(format, bgr.width(), bgr.height(), bgr.tone_curve());
  std::uint8_t* to = out.bytes().data();
  for (int y = 0; y < bgr.height(); ++y)
    for (int x = 0; x < bgr.width(); ++x) *to++ = bgr.row(y)[3 * x + BayerColour(format, x, y)];
  return out;
}

/// Pixel by pixel: `value` gives one colour (kBlue …) of a pixel.
template <typename Value>
Image FillBgr(const ImageView& like, const Value& value) {
  Image out(PixelFormat::kBgr8, like.width(), like.height(), like.tone_curve());
  std::uint8_t* to = out.bytes().data();
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x)
      for (int colour = 0; colour < 3; ++colour) *to++ = value(x, y, colour);
  return out;
}

Image YuvToBgr(const ImageView& image) {
  const YuvReader reader(image);
  return FillBgr(image, [&](int x, int y, int colour) {
    return Clipped(BgrFromYuv(reader.At(x, y))[static_cast<std::size_t>(colour)]);
  });
}

}  // namespace

Image ToBgr(const ImageView& image) {
  switch (image.format()) {
    case PixelFormat::kBgr8: return Copy(image);
    case PixelFormat::kRgb8: return SwapRedAndBlue(image, PixelFormat::kBgr8);
    case PixelFormat::kMono8: return FillBgr(image, [&](int x, int y, int) { return image.row(y)[x]; });
    default: break;
  }
  if (IsYuv(image.format())) return YuvToBgr(image);
  return FillBgr(image, [&](int x, int y, int colour) { return DemosaicPixel(image, x, y, colour); });
}

Image ConvertImage(const ImageView& image, PixelFormat format, YuvRange yuv_range) {
  CHEQUER_CHECK(SizeIsValid(format, image.width(), image.height()), "image size not valid for the format wanted");
  const bool same_range = !IsYuv(format) || image.yuv_range() == yuv_range;
  if (image.format() == format && same_range) return Copy(image);
  if (IsYuv(image.format()) && IsYuv(format)) return WriteYuv(YuvReader(image), image, format, yuv_range);
  if (IsYuv(image.format()) && format == PixelFormat::kMono8) return WriteLuma(YuvReader(image), image);
  Image bgr = ToBgr(image);
  if (format == PixelFormat::kBgr8) return bgr;
  const ImageView view = bgr.view();
  if (format == PixelFormat::kRgb8) return SwapRedAndBlue(view, format);
  if (format == PixelFormat::kMono8) return WriteLuma(BgrReader(view), view);
  if (IsBayer(format)) return Mosaic(view, format);
  return WriteYuv(BgrReader(view), view, format, yuv_range);
}

}  // namespace chequer
