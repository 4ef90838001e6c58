#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "capture/image_pool.h"
#include "capture/jpeg.h"

namespace chequer {
namespace {

Image Slope(PixelFormat format, int width, int height) {
  Image image(format, width, height);
  const std::span<std::uint8_t> bytes = image.bytes();
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i / 16 + 3 * (i % 16));
  return image;
}

bool Same(const Image& a, const Image& b) { return std::ranges::equal(a.bytes(), b.bytes()); }

/// A JPEG without its Huffman tables, as many webcams send it: all would be the same.
std::vector<std::uint8_t> WithoutTables(const std::vector<std::uint8_t>& jpeg) {
  std::vector<std::uint8_t> out(jpeg.begin(), jpeg.begin() + 2);
  std::size_t at = 2;
  while (jpeg[at + 1] != 0xDA) {  // the picture itself begins
    const std::size_t length = 2 + (std::size_t{jpeg[at + 2]} << 8) + jpeg[at + 3];
    if (jpeg[at + 1] != 0xC4)
      out.insert(out.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at),
                 jpeg.begin() + static_cast<std::ptrdiff_t>(at + length));
    at += length;
  }
  out.insert(out.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at), jpeg.end());
  return out;
}

TEST(DecodeJpeg, NeedsNoHuffmanTables) {
  const std::vector<std::uint8_t> jpeg = JpegFromImage(Slope(PixelFormat::kYuv422p, 64, 48).view());
  const std::vector<std::uint8_t> bare = WithoutTables(jpeg);
  ASSERT_LT(bare.size(), jpeg.size());
  const Image image = ImageFromJpeg(bare, JpegColour::kYuv);
  EXPECT_EQ(image.format(), PixelFormat::kYuv422p);
  EXPECT_TRUE(Same(image, ImageFromJpeg(jpeg, JpegColour::kYuv)));
}

TEST(DecodeJpeg, UsesAnImageAgain) {
  const std::vector<std::uint8_t> jpeg = JpegFromImage(Slope(PixelFormat::kYuv420p, 64, 48).view());
  Image image;
  DecodeJpeg(jpeg, JpegColour::kYuv, ToneCurve::Srgb(), image);
  const std::uint8_t* place = image.bytes().data();
  DecodeJpeg(jpeg, JpegColour::kYuv, ToneCurve::Srgb(), image);
  EXPECT_EQ(image.bytes().data(), place);
  DecodeJpeg(JpegFromImage(Slope(PixelFormat::kYuv420p, 32, 48).view()), JpegColour::kYuv, ToneCurve::Srgb(), image);
  EXPECT_EQ(image.width(), 32);
}

TEST(CopyPixels, LeavesOutThePaddingOfRows) {
  const Image wide = Slope(PixelFormat::kYuyv, 16, 4);
  const std::vector<Plane> planes{{wide.bytes().data(), 32}};
  Image copy;
  CopyPixels(ImageView(PixelFormat::kYuyv, 8, 4, planes), copy);
  ASSERT_EQ(copy.bytes().size(), 64u);
  for (std::size_t y = 0; y < 4; ++y)
    EXPECT_TRUE(std::ranges::equal(copy.bytes().subspan(16 * y, 16), wide.bytes().subspan(32 * y, 16)));
}

TEST(CopyPixels, CopiesEveryPlane) {
  const Image image = Slope(PixelFormat::kNv12, 8, 4);
  Image copy(PixelFormat::kMono8, 3, 3);
  CopyPixels(image.view(), copy);
  EXPECT_TRUE(Same(image, copy));
}

TEST(ImagePool, GivesImagesAgainWhenTheirFramesAreGone) {
  auto pool = ImagePool::Make();
  Image image(PixelFormat::kMono8, 8, 4);
  const std::uint8_t* place = image.bytes().data();
  std::unique_ptr<FrameLease> lease = pool->Lend(std::move(image));
  EXPECT_TRUE(pool->Take().empty());
  lease.reset();
  EXPECT_EQ(pool->Take().bytes().data(), place);
  lease = pool->Lend(Image(PixelFormat::kMono8, 8, 4));
  pool.reset();  // the frame outlives its source
  lease.reset();
}

}  // namespace
}  // namespace chequer
