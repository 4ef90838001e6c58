#include "capture/image_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <functional>
#include <stdexcept>
#include <string>

#include "capture/png.h"
#include "core/file.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

using test::ErrorOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::filesystem::path Sample(const std::string& name) {
  return std::filesystem::path(CHEQUER_TEST_DATA) / "unit/capture/images" / name;
}

std::string DecodeError(std::span<const std::uint8_t> bytes) {
  return ErrorOf([&] { DecodeImage(bytes); });
}

std::span<const std::uint8_t> Bytes(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// Something that no codec can guess: every pixel another value, smooth enough for JPEG.
Image Gradient(PixelFormat format, int width, int height) {
  Image image(format, width, height);
  const auto row_bytes = static_cast<std::size_t>(PlaneShapes(format, width, height)[0].row_bytes);
  for (std::size_t i = 0; i < image.bytes().size(); ++i)
    image.bytes()[i] = static_cast<std::uint8_t>(20 + (i % row_bytes) * 100 / row_bytes + i / row_bytes);
  return image;
}

int LargestDifference(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
  if (a.size() != b.size()) return 256;
  int largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

TEST(Png, GivesBackWhatWasWritten) {
  for (const PixelFormat format : {PixelFormat::kBgr8, PixelFormat::kMono8}) {
    const Image image = Gradient(format, 33, 17);
    const Image read = DecodeImage(PngFromImage(image.view()));
    EXPECT_EQ(read.format(), format);
    EXPECT_EQ(read.width(), 33);
    EXPECT_EQ(read.height(), 17);
    EXPECT_EQ(LargestDifference(read.bytes(), image.bytes()), 0);
  }
}

TEST(Png, WritesAnImageWhoseRowsAreFarApart) {
  const Image image = Gradient(PixelFormat::kMono8, 40, 10);
  const Plane plane{image.view().row(2) + 5, 40};
  const Image read = DecodeImage(PngFromImage(ImageView(PixelFormat::kMono8, 20, 6, {&plane, 1})));
  EXPECT_EQ(read.view().row(3)[7], image.view().row(5)[12]);
}

TEST(Png, OneChannelHoldsWhatIsStated) {
  const Image raw = Gradient(PixelFormat::kBayerGb8, 8, 6);
  const Image read = DecodeImage(PngFromImage(raw.view()), {.one_channel = PixelFormat::kBayerGb8});
  EXPECT_EQ(read.format(), PixelFormat::kBayerGb8);
  EXPECT_EQ(LargestDifference(read.bytes(), raw.bytes()), 0);
}

TEST(Png, EveryKindOf8BitsIsRead) {
  EXPECT_THAT(LoadImage(Sample("grey1.png")).bytes(), ElementsAre(255, 0, 255, 0, 0, 255, 0, 255));
  EXPECT_THAT(LoadImage(Sample("palette.png")).bytes(), ElementsAre(30, 20, 10, 60, 50, 40, 60, 50, 40, 30, 20, 10));
  EXPECT_THAT(LoadImage(Sample("colour_alpha.png")).bytes(), ElementsAre(3, 2, 1, 6, 5, 4));
  EXPECT_THAT(LoadImage(Sample("grey_alpha.png")).bytes(), ElementsAre(7, 9));
  EXPECT_THAT(LoadImage(Sample("grey_gamma.png")).bytes(), ElementsAre(50, 200));
  EXPECT_THAT(LoadImage(Sample("interlaced.png")).bytes(),
              ElementsAre(0, 1, 2, 3, 16, 17, 18, 19, 32, 33, 34, 35, 48, 49, 50, 51));
}

TEST(Png, RefusesSixteenBits) {
  EXPECT_THAT(ErrorOf([] { LoadImage(Sample("grey16.png")); }),
              HasSubstr("grey16.png: unusable PNG file: it has 16 bits"));
  EXPECT_THAT(ErrorOf([] { LoadImage(Sample("colour16.png")); }), HasSubstr("16 bits a sample"));
}

TEST(Png, RefusesSizesBeforeAnythingIsAllocated) {
  EXPECT_THAT(ErrorOf([] { LoadImage(Sample("promises_too_much.png")); }), HasSubstr("16384 x 16384 pixels; allowed"));
  EXPECT_THAT(ErrorOf([] { LoadImage(Sample("zero_width.png")); }), HasSubstr("unusable PNG file"));
}

TEST(Png, AnyCutIsAnError) {
  const auto whole = PngFromImage(Gradient(PixelFormat::kBgr8, 20, 20).view());
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_NE(DecodeError(std::span(whole).first(size)), "no error") << size << " of " << whole.size();
}

TEST(Png, AWrongBitIsAnError) {
  auto bytes = PngFromImage(Gradient(PixelFormat::kBgr8, 20, 20).view());
  bytes[bytes.size() / 2] ^= 0x10;
  EXPECT_THAT(DecodeError(bytes), HasSubstr("unusable PNG file: "));
}

TEST(Jpeg, GivesBackNearlyWhatWasWritten) {
  for (const PixelFormat format : {PixelFormat::kBgr8, PixelFormat::kMono8}) {
    const Image image = Gradient(format, 33, 17);
    const Image read = DecodeImage(JpegFromImage(image.view(), {.quality = 98, .chroma = ChromaSharing::k444}));
    EXPECT_EQ(read.format(), format);
    EXPECT_LE(LargestDifference(read.bytes(), image.bytes()), 4);
  }
}

TEST(Jpeg, RgbAndBgrMeanTheSameColours) {
  const Image bgr = Gradient(PixelFormat::kBgr8, 16, 16);
  Image rgb(PixelFormat::kRgb8, 16, 16);
  for (std::size_t i = 0; i < rgb.bytes().size(); ++i) rgb.bytes()[i] = bgr.bytes()[i / 3 * 3 + 2 - i % 3];
  EXPECT_EQ(JpegFromImage(rgb.view()), JpegFromImage(bgr.view()));
}

TEST(Jpeg, PlanarYuvGoesThereAndBackAlsoAtOddSizes) {
  for (const PixelFormat format : {PixelFormat::kYuv420p, PixelFormat::kYuv422p, PixelFormat::kYuv444p})
    for (const int width : {32, 33})
      for (const int height : {16, 17}) {
        const Image image = Gradient(format, width, height);
        const auto bytes = JpegFromImage(image.view(), {.quality = 98});
        const Image read = DecodeImage(bytes, {.jpeg_colour = JpegColour::kYuv});
        EXPECT_EQ(read.format(), format);
        EXPECT_EQ(read.width(), width);
        EXPECT_EQ(read.height(), height);
        EXPECT_LE(LargestDifference(read.bytes(), image.bytes()), 12) << PixelFormatName(format) << width << height;
        EXPECT_EQ(DecodeImage(bytes).format(), PixelFormat::kBgr8);
      }
}

TEST(Jpeg, AGreyOneStaysOneChannelWhenYuvIsWanted) {
  const auto bytes = JpegFromImage(Gradient(PixelFormat::kMono8, 16, 16).view());
  EXPECT_EQ(DecodeImage(bytes, {.jpeg_colour = JpegColour::kYuv}).format(), PixelFormat::kMono8);
}

TEST(Jpeg, HoldsWhatItCan) {
  EXPECT_TRUE(JpegHolds(PixelFormat::kYuv420p, YuvRange::kFull));
  EXPECT_FALSE(JpegHolds(PixelFormat::kYuv420p, YuvRange::kLimited));
  EXPECT_FALSE(JpegHolds(PixelFormat::kYuyv, YuvRange::kFull));
  EXPECT_FALSE(JpegHolds(PixelFormat::kBayerRg8, YuvRange::kFull));
}

TEST(Jpeg, AnyCutIsAnErrorNotAHalfGreyPicture) {
  const auto whole = JpegFromImage(Gradient(PixelFormat::kBgr8, 64, 64).view());
  // The last two bytes are the end marker: without them all pixels may be there, and still it is refused.
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_NE(DecodeError(std::span(whole).first(size)), "no error") << size << " of " << whole.size();
}

TEST(Jpeg, StrayBytesBeforeTheEndMarkerAreForgiven) {
  const auto whole = JpegFromImage(Gradient(PixelFormat::kBgr8, 64, 64).view());
  auto stray = whole;
  stray.insert(stray.end() - 2, {0x12, 0x34});
  EXPECT_EQ(LargestDifference(DecodeImage(stray).bytes(), DecodeImage(whole).bytes()), 0);
}

TEST(Jpeg, PaddingAfterTheEndIsForgiven) {
  auto padded = JpegFromImage(Gradient(PixelFormat::kBgr8, 64, 64).view());
  padded.resize(padded.size() + 100);
  EXPECT_EQ(DecodeImage(padded).width(), 64);
}

TEST(Jpeg, OrientationFromExifIsNotApplied) {
  auto bytes = JpegFromImage(Gradient(PixelFormat::kBgr8, 32, 16).view());
  // An APP1 segment with orientation 6 (a quarter turn), little endian.
  const std::string exif(
      "\xff\xe1\x00\x22"
      "Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0",
      36);
  bytes.insert(bytes.begin() + 2, exif.begin(), exif.end());
  const Image read = DecodeImage(bytes);
  EXPECT_EQ(read.width(), 32);
  EXPECT_EQ(read.height(), 16);
}

TEST(Pnm, IsRead) {
  const Image grey = DecodeImage(Bytes("P5 # a comment\n2 1\n255\n\x07\x08"));
  EXPECT_EQ(grey.format(), PixelFormat::kMono8);
  EXPECT_THAT(grey.bytes(), ElementsAre(7, 8));
  EXPECT_THAT(DecodeImage(Bytes("P6\n1 1 255 \x01\x02\x03")).bytes(), ElementsAre(3, 2, 1));
}

TEST(Pnm, SaysWhatIsWrong) {
  EXPECT_THAT(DecodeError(Bytes("P2\n1 1\n255\n7")), HasSubstr("only binary grey (P5) and colour (P6)"));
  EXPECT_THAT(DecodeError(Bytes("P5\n1 1\n65535\n77")), HasSubstr("largest value is 65535; only 255"));
  EXPECT_THAT(DecodeError(Bytes("P5\n2 2\n255\n123")), HasSubstr("it is truncated: 3 bytes of 4"));
  EXPECT_THAT(DecodeError(Bytes("P5\n0 2\n255\n123")), HasSubstr("0 x 2 pixels; allowed"));
  EXPECT_THAT(DecodeError(Bytes("P5\n99999999999999999999 2\n255\n123")), HasSubstr("pixels; allowed"));
  EXPECT_THAT(DecodeError(Bytes("P5\n-1 2\n255\n123")), HasSubstr("no number where one must be"));
  EXPECT_THAT(DecodeError(Bytes("P5\n1 1\n255")), HasSubstr("does not end with a blank"));
  EXPECT_THAT(DecodeError(Bytes("P5")), HasSubstr("no number"));
  EXPECT_THAT(DecodeError(Bytes("P5#")), HasSubstr("no number"));
}

/// A BMP's bytes: file header, info header, palette, pixels.
std::string Bmp(int width, int height, int bits, const std::string& palette, const std::string& pixels,
                int compression = 0) {
  const auto le = [](int value, int count) {
    std::string text;
    for (int i = 0; i < count; ++i)
      text += static_cast<char>(i < 4 ? static_cast<unsigned>(value) >> (8 * i) & 255u : 0u);
    return text;
  };
  const int entries = static_cast<int>(palette.size() / 4);
  return "BM" + le(0, 8) + le(54 + 4 * entries, 4) + le(40, 4) + le(width, 4) + le(height, 4) + le(1, 2) + le(bits, 2) +
         le(compression, 4) + le(0, 12) + le(entries, 4) + le(0, 4) + palette + pixels;
}

TEST(Bmp, IsRead) {
  const std::string two_rows("\1\2\3\0\4\5\6\0", 8);
  EXPECT_THAT(DecodeImage(Bytes(Bmp(1, 2, 24, "", two_rows))).bytes(), ElementsAre(4, 5, 6, 1, 2, 3));
  EXPECT_THAT(DecodeImage(Bytes(Bmp(1, -2, 24, "", two_rows))).bytes(), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(DecodeImage(Bytes(Bmp(2, 1, 32, "", two_rows))).bytes(), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(DecodeImage(Bytes(Bmp(2, 1, 8, std::string("\1\2\3\0\4\5\6\0", 8), std::string("\1\0\0\0", 4)))).bytes(),
              ElementsAre(4, 5, 6, 1, 2, 3));
  std::string grey_scale;
  for (int i = 0; i < 256; ++i) grey_scale += std::string(3, static_cast<char>(i)) + std::string(1, '\0');
  const Image grey = DecodeImage(Bytes(Bmp(1, 1, 8, grey_scale, std::string("\x99\0\0\0", 4))));
  EXPECT_EQ(grey.format(), PixelFormat::kMono8);
  EXPECT_THAT(grey.bytes(), ElementsAre(0x99));
}

TEST(Bmp, SaysWhatIsWrong) {
  EXPECT_THAT(DecodeError(Bytes("BM")), HasSubstr("it is truncated: 2 bytes of 54"));
  EXPECT_THAT(DecodeError(Bytes(Bmp(1, 2, 24, "", "1234567"))), HasSubstr("it is truncated: 61 bytes of 62"));
  EXPECT_THAT(DecodeError(Bytes(Bmp(1, 1, 16, "", "1234"))), HasSubstr("16 bits a pixel; only 8, 24 and 32"));
  EXPECT_THAT(DecodeError(Bytes(Bmp(1, 1, 8, "", "1234"))), HasSubstr("it is truncated"));
  EXPECT_THAT(DecodeError(Bytes(Bmp(1, 1, 24, "", "1234", 1))), HasSubstr("it is compressed"));
  EXPECT_THAT(DecodeError(Bytes(Bmp(-1, 1, 24, "", "1234"))), HasSubstr("-1 x 1 pixels; allowed"));
  EXPECT_THAT(DecodeError(Bytes(Bmp(1, INT32_MIN, 24, "", "1234"))), HasSubstr("1 x 2147483648 pixels; allowed"));
}

TEST(LoadImage, NamesFileAndCause) {
  const test::TemporaryDirectory folder;
  const auto error_of = [&](const char* name) { return ErrorOf([&] { LoadImage(folder / name); }); };
  EXPECT_THAT(error_of("gone.png"), HasSubstr("gone.png: cannot be opened: No such file or directory"));
  WriteFileAtomically(folder / "empty.png", "");
  EXPECT_THAT(error_of("empty.png"), HasSubstr("empty.png: the file is empty"));
  WriteFileAtomically(folder / "text.png", "hello");
  EXPECT_THAT(error_of("text.png"), HasSubstr("text.png: not an image of a kind that is read here"));
  EXPECT_THAT(error_of("."), HasSubstr("is a folder, not a file"));
  ASSERT_EQ(::mkfifo((folder / "pipe.png").c_str(), 0600), 0);
  EXPECT_THAT(error_of("pipe.png"), HasSubstr("pipe.png: is a pipe, not a file"));
}

TEST(LoadRawImage, NeedsExactlyItsBytes) {
  const test::TemporaryDirectory folder;
  const RawLayout layout{PixelFormat::kYuyv, 2, 1, ToneCurve::Linear(), YuvRange::kLimited};
  WriteFileAtomically(folder / "x.raw", "abcd");
  const Image image = LoadRawImage(folder / "x.raw", layout);
  EXPECT_THAT(image.bytes(), ElementsAre('a', 'b', 'c', 'd'));
  EXPECT_EQ(image.view().tone_curve(), ToneCurve::Linear());
  EXPECT_EQ(image.view().yuv_range(), YuvRange::kLimited);
  WriteFileAtomically(folder / "x.raw", "abc");
  EXPECT_THAT(ErrorOf([&] { LoadRawImage(folder / "x.raw", layout); }),
              HasSubstr("x.raw: has 3 bytes; 2 x 1 YUYV needs 4"));
  WriteFileAtomically(folder / "x.raw", "abcde");
  EXPECT_THAT(ErrorOf([&] { LoadRawImage(folder / "x.raw", layout); }), HasSubstr("has 5 bytes"));
}

TEST(HasImageExtension, KnowsWhatIsRead) {
  EXPECT_TRUE(HasImageExtension("a/b.PNG"));
  EXPECT_TRUE(HasImageExtension("b.jpeg"));
  EXPECT_FALSE(HasImageExtension("b.raw"));
  EXPECT_FALSE(HasImageExtension("png"));
}

}  // namespace
}  // namespace chequer
