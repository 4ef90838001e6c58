#include "print/draw.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "print/png_pixel_size.h"

namespace chequer {
namespace {

using ::testing::HasSubstr;

SheetOptions Options(std::vector<std::uint64_t> ids) {
  SheetOptions options;
  options.ids = std::move(ids);
  return options;
}

std::string Text(const std::vector<std::uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

TEST(Draw, PdfIsOneFileInTrueSize) {
  const SheetOptions options = Options({1, 2, 3, 4, 5, 6, 7});
  const PrintedFile file = DrawPdf(options, LayOutSheet(options));
  EXPECT_EQ(file.suffix, "");
  EXPECT_EQ(Text(file.bytes).substr(0, 5), "%PDF-");
  EXPECT_THAT(Text(file.bytes), HasSubstr("/MediaBox [ 0 0 595.275"));
  // Vectors, no picture.
  EXPECT_EQ(Text(file.bytes).find("/Image"), std::string::npos);
}

TEST(Draw, SvgIsAFileAPageWithACellARectangle) {
  const SheetOptions options = Options({1, 2, 3, 4, 5, 6, 7});
  const auto files = DrawSvg(options, LayOutSheet(options));
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[0].suffix, "-1");
  EXPECT_EQ(files[1].suffix, "-2");
  EXPECT_THAT(Text(files[0].bytes), HasSubstr("pt\""));
  EXPECT_EQ(Text(files[0].bytes).find("<image"), std::string::npos);
  const SheetOptions one = Options({1});
  EXPECT_EQ(DrawSvg(one, LayOutSheet(one))[0].suffix, "");
}

int CountOf(const std::string& part, const std::string& text) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(Draw, AnUprightBarStandsInABorderThatHasRoomForIt) {
  SheetOptions options = Options({1});
  const std::string with = Text(DrawSvg(options, LayOutSheet(options))[0].bytes);
  options.border_m = 0.004;
  ASSERT_EQ(LayOutSheet(options).upright_bar_m, 0);
  const std::string without = Text(DrawSvg(options, LayOutSheet(options))[0].bytes);
  // The bar, and a tick at each centimetre of 100 mm.
  EXPECT_EQ(CountOf("stroke-linecap", with) - CountOf("stroke-linecap", without), 12);
}

TEST(Draw, PngSaysHowLargeItsPixelsAre) {
  const SheetOptions options = Options({1});
  const auto files = DrawPng(options, LayOutSheet(options), 254);
  ASSERT_EQ(files.size(), 1u);
  const std::vector<std::uint8_t>& png = files[0].bytes;
  // Header, then pHYs: 10000 pixels a metre both ways.
  const std::vector<std::uint8_t> expected{0, 0, 0, 9, 'p', 'H', 'Y', 's', 0, 0, 0x27, 0x10, 0, 0, 0x27, 0x10, 1};
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), png.begin() + 33));
  // The rest is as it was: the next chunk follows the checksum.
  EXPECT_THAT(Text({png.begin() + 33 + 21, png.end()}), HasSubstr("IDAT"));
}

TEST(Draw, RefusesImagesThatNothingHolds) {
  const SheetOptions options = Options({1});
  try {
    DrawPng(options, LayOutSheet(options), 4800);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("fewer dots per inch"));
  }
}

}  // namespace
}  // namespace chequer
