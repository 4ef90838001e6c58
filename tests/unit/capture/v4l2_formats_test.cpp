#include "capture/v4l2_formats.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace chequer {
namespace {

using ::testing::HasSubstr;

constexpr FourCc kYuyv = MakeFourCc("YUYV");
constexpr FourCc kMjpg = MakeFourCc("MJPG");
constexpr FourCc kGrey = MakeFourCc("GREY");
constexpr FourCc kBayer = MakeFourCc("RGGB");

V4l2SizeOffer Size(int width, int height, std::vector<double> rates_hz) {
  return {width, width, 1, height, height, 1, std::move(rates_hz)};
}

/// A webcam as most are: large pictures fast as JPEG alone.
std::vector<V4l2FormatOffer> Webcam() {
  return {{kYuyv, "YUYV 4:2:2", {Size(640, 480, {30, 15}), Size(1920, 1080, {5})}},
          {kMjpg, "Motion-JPEG", {Size(640, 480, {60, 30}), Size(1920, 1080, {30})}},
          {MakeFourCc("H264"), "H.264", {Size(1920, 1080, {60})}}};
}

V4l2FormatChoice Choose(const V4l2FormatWish& wish, const std::vector<V4l2FormatOffer>& offers = Webcam()) {
  return ChooseV4l2Format(offers, wish, 320, 240);
}

void ExpectChoice(const V4l2FormatChoice& choice, FourCc code, int width, int height) {
  EXPECT_EQ(choice.wrong, "");
  EXPECT_EQ(FourCcText(choice.code), FourCcText(code));
  EXPECT_EQ(choice.width, width);
  EXPECT_EQ(choice.height, height);
}

TEST(ChooseV4l2Format, TakesTheMostPixelsThatAreFastEnough) {
  ExpectChoice(Choose({}), kMjpg, 1920, 1080);
  ExpectChoice(Choose({{}, {}, {}, 60}), kMjpg, 640, 480);
  ExpectChoice(Choose({{}, {}, {}, 5}), kYuyv, 1920, 1080);
}

TEST(ChooseV4l2Format, TakesWhatLosesLeastAtTheSizeThatIsWanted) {
  ExpectChoice(Choose({{}, 640, 480, 30}), kYuyv, 640, 480);
  ExpectChoice(Choose({{}, 640, 480, 60}), kMjpg, 640, 480);
  const std::vector<V4l2FormatOffer> raw{{kYuyv, "", {Size(640, 480, {30})}}, {kBayer, "", {Size(640, 480, {30})}}};
  ExpectChoice(Choose({}, raw), kBayer, 640, 480);
}

TEST(ChooseV4l2Format, TakesGreyOnlyWhereThereIsNothingElse) {
  const std::vector<V4l2FormatOffer> fast_grey{{kGrey, "", {Size(1920, 1080, {200})}},
                                               {kYuyv, "", {Size(640, 480, {10})}}};
  ExpectChoice(Choose({}, fast_grey), kYuyv, 640, 480);
  ExpectChoice(Choose({}, {fast_grey.front()}), kGrey, 1920, 1080);
}

TEST(ChooseV4l2Format, HoldsSizesToTheStepsOfARange) {
  const std::vector<V4l2FormatOffer> range{{kYuyv, "", {{16, 1920, 16, 16, 1080, 4, {60, 1}}}}};
  ExpectChoice(Choose({{}, 640, 480, 30}, range), kYuyv, 640, 480);
  ExpectChoice(Choose({}, range), kYuyv, 1920, 1080);
  EXPECT_THAT(Choose({{}, 641, 480, 30}, range).wrong, HasSubstr("16x16 to 1920x1080 (60, 1 fps)"));
}

TEST(ChooseV4l2Format, TakesTheSizeThatIsSetWhereTheDriverNamesNone) {
  ExpectChoice(Choose({}, {{kYuyv, "", {}}}), kYuyv, 320, 240);
  ExpectChoice(Choose({{}, 640, 480, 30}, {{kYuyv, "", {}}}), kYuyv, 640, 480);
}

TEST(ChooseV4l2Format, SaysWhatThereIs) {
  const V4l2FormatChoice format = Choose({"NV12", {}, {}, 30});
  EXPECT_EQ(format.wrong_key, V4l2FormatChoice::Key::kPixelFormat);
  EXPECT_EQ(format.wrong, "the camera does not offer NV12; it offers YUYV, MJPEG");
  const V4l2FormatChoice size = Choose({"YUYV", 800, 600, 30});
  EXPECT_EQ(size.wrong_key, V4l2FormatChoice::Key::kSize);
  EXPECT_EQ(size.wrong, "the camera does not offer 800x600; it offers YUYV 640x480 (30, 15 fps), 1920x1080 (5 fps)");
  EXPECT_EQ(Choose({}, {{MakeFourCc("H264"), "", {}}}).wrong, "none of the camera's formats can be used: H264");
  EXPECT_EQ(Choose({}, {}).wrong, "none of the camera's formats can be used: it has none");
}

TEST(FourCc, HasTheNameThatConfigurationsUse) {
  EXPECT_EQ(NameOfFourCc(kMjpg), "MJPEG");
  EXPECT_EQ(NameOfFourCc(MakeFourCc("BA81")), "BayerBG8");
  EXPECT_EQ(NameOfFourCc(MakeFourCc("H264")), "");
  EXPECT_EQ(PixelFormatOf(MakeFourCc("NV12")), PixelFormat::kNv12);
  EXPECT_EQ(PixelFormatOf(kMjpg), std::nullopt);
  EXPECT_EQ(FourCcText(0x01020304), "....");
}

}  // namespace
}  // namespace chequer
