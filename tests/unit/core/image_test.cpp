#include "chequer/image.h"

#include <gtest/gtest.h>

namespace chequer {
namespace {

TEST(PixelFormat, NamesGoThereAndBack) {
  for (int i = 0; i <= static_cast<int>(PixelFormat::kYuv444p); ++i) {
    const auto format = static_cast<PixelFormat>(i);
    EXPECT_EQ(ParsePixelFormat(PixelFormatName(format)), format);
  }
  EXPECT_EQ(ParsePixelFormat("bgr8"), std::nullopt);
  EXPECT_EQ(ParsePixelFormat(""), std::nullopt);
}

TEST(Image, PlanesFollowEachOtherWithoutGaps) {
  const Image image(PixelFormat::kYuv420p, 5, 3);
  EXPECT_EQ(image.bytes().size(), 15u + 2 * 6u);
  const ImageView view = image.view();
  EXPECT_EQ(view.plane(1).data, image.bytes().data() + 15);
  EXPECT_EQ(view.plane(2).data, image.bytes().data() + 21);
  EXPECT_EQ(view.plane(1).stride_bytes, 3);
}

TEST(ViewPacked, RefusesTooFewBytesAndOddSizes) {
  const std::vector<std::uint8_t> bytes(100);
  EXPECT_TRUE(ViewPacked(PixelFormat::kMono8, 10, 10, bytes).has_value());
  EXPECT_FALSE(ViewPacked(PixelFormat::kMono8, 10, 11, bytes).has_value());
  EXPECT_FALSE(ViewPacked(PixelFormat::kYuyv, 7, 2, bytes).has_value());
  EXPECT_FALSE(ViewPacked(PixelFormat::kNv12, 6, 3, bytes).has_value());
  EXPECT_FALSE(ViewPacked(PixelFormat::kMono8, 0, 10, bytes).has_value());
  EXPECT_FALSE(ViewPacked(PixelFormat::kMono8, -1, 10, bytes).has_value());
}

TEST(ImageViewDeathTest, AShortStrideIsABug) {
  const std::vector<std::uint8_t> bytes(100);
  const Plane plane{bytes.data(), 9};
  EXPECT_DEATH(ImageView(PixelFormat::kMono8, 10, 10, {&plane, 1}), "stride shorter than a row");
}

}  // namespace
}  // namespace chequer
