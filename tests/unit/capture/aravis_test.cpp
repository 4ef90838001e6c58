#include <arv.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "capture/aravis_devices.h"
#include "capture/aravis_formats.h"
#include "capture/aravis_source.h"
#include "support/sanitizers.h"

namespace chequer {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(GenicamFormat, IsFoundByNameAndByCode) {
  EXPECT_EQ(PixelFormatOfGenicam("BayerRG8"), PixelFormat::kBayerRg8);
  EXPECT_EQ(PixelFormatOfGenicam("YUV422Packed"), PixelFormat::kUyvy);
  EXPECT_EQ(PixelFormatOfGenicam("Mono12"), std::nullopt);
  EXPECT_EQ(PixelFormatOfGenicam(std::uint32_t{ARV_PIXEL_FORMAT_BAYER_GB_8}), PixelFormat::kBayerGb8);
  EXPECT_EQ(PixelFormatOfGenicam(std::uint32_t{ARV_PIXEL_FORMAT_BGR_8_PACKED}), PixelFormat::kBgr8);
  EXPECT_EQ(PixelFormatOfGenicam(std::uint32_t{ARV_PIXEL_FORMAT_YUV_422_YUYV_PACKED}), PixelFormat::kYuyv);
  EXPECT_EQ(PixelFormatOfGenicam(std::uint32_t{ARV_PIXEL_FORMAT_MONO_16}), std::nullopt);
}

TEST(ChooseGenicamFormat, TakesWhatIsWantedOrTheBest) {
  EXPECT_EQ(ChooseGenicamFormat({"Mono8", "RGB8Packed", "BayerGR8"}, std::nullopt).name, "BayerGR8");
  EXPECT_EQ(ChooseGenicamFormat({"Mono8", "RGB8Packed"}, "RGB8").name, "RGB8Packed");
  EXPECT_EQ(ChooseGenicamFormat({"Mono12", "Mono8"}, std::nullopt).name, "Mono8");
  EXPECT_EQ(ChooseGenicamFormat({"Mono8", "RGB8", "Mono12"}, "BGR8").wrong,
            "the camera does not offer BGR8; it offers Mono8, RGB8");
  EXPECT_EQ(ChooseGenicamFormat({"Mono12"}, std::nullopt).wrong, "none of the camera's formats can be used: Mono12");
}

const AravisDevice kLeft{"Maker-Cam-1", "Maker", "Cam", "1", "10.0.0.1", "aa:01", "GigEVision"};
const AravisDevice kRight{"Maker-Cam-2", "Maker", "Cam", "2", "10.0.0.2", "aa:02", "GigEVision"};

AravisFound Find(const std::vector<AravisDevice>& devices, const std::string& device,
                 const std::optional<AravisDevice>& known = std::nullopt) {
  return FindAravisDevice(devices, device, "capture.device", known);
}

TEST(FindAravisDevice, ByIdSerialNumberAddressAndModel) {
  for (const char* name : {"Maker-Cam-2", "2", "10.0.0.2", "aa:02"})
    EXPECT_EQ(Find({kLeft, kRight}, name).device, kRight) << name;
  EXPECT_EQ(Find({kRight}, "Maker Cam").device, kRight);
  EXPECT_EQ(Find({kRight}, "Cam").device, kRight);
  EXPECT_EQ(Find({kRight}, "").device, kRight);
}

TEST(FindAravisDevice, SaysWhatAnswers) {
  EXPECT_EQ(Find({kLeft}, "3").problem,
            "capture.device: no camera '3' answers; there are Maker-Cam-1 (GigEVision, serial 1, at 10.0.0.1)");
  EXPECT_EQ(Find({}, "").problem, "capture.device: no GenICam camera answers");
  EXPECT_THROW(Find({kLeft, kRight}, "Cam"), std::runtime_error);
  EXPECT_THROW(Find({kLeft, kRight}, ""), std::runtime_error);
}

TEST(FindAravisDevice, FindsTheSameCameraAtAnotherAddress) {
  AravisDevice moved = kLeft;
  moved.address = "10.0.0.9";
  EXPECT_EQ(Find({kRight, moved}, "10.0.0.1", kLeft).device, moved);
  AravisDevice other = kRight;
  other.address = "10.0.0.1";
  EXPECT_EQ(Find({other}, "10.0.0.1", kLeft).device, std::nullopt);
}

TEST(IsIpAddress, KnowsThem) {
  EXPECT_TRUE(IsIpAddress("192.168.0.7"));
  EXPECT_FALSE(IsIpAddress("camera"));
  EXPECT_FALSE(IsIpAddress(""));
}

/// The camera that Aravis has within the process. Nobody in the network is asked.
class AravisFakeTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    arv_disable_interface("GigEVision");
    arv_disable_interface("USB3Vision");
  }
  void SetUp() override {
#ifdef CHEQUER_THREAD_SANITIZER
    GTEST_SKIP() << "GLib's locks are not made for the thread sanitizer, which takes what they guard for races";
#endif
  }

  static AravisOptions Fake() {
    AravisOptions options;
    options.camera.device = "Fake_1";
    options.camera.fps = 100;
    options.camera.width = 64;
    options.camera.height = 48;
    return options;
  }

  static std::string OpenError(const AravisOptions& options) {
    try {
      return AravisSource(options).Open();
    } catch (const std::runtime_error& error) {
      return std::string("throws ") + error.what();
    }
  }
};

TEST_F(AravisFakeTest, GivesFramesWithTimesAndNumbers) {
  AravisSource source(Fake());
  ASSERT_EQ(source.Open(), "");
  EXPECT_THAT(source.Remarks(), IsEmpty());
  EXPECT_EQ(source.rate_hz(), 100);
  EXPECT_THAT(source.Describe(), HasSubstr("64x48 BayerRG8, 100 fps"));
  std::uint64_t last = 0;
  for (int i = 0; i < 20; ++i) {
    const CaptureResult result = source.Next(5s);
    ASSERT_EQ(result.status, CaptureStatus::kFrame) << result.message;
    EXPECT_EQ(result.frame.image.width(), 64);
    EXPECT_EQ(result.frame.image.format(), PixelFormat::kBayerRg8);
    if (i > 0) {
      EXPECT_EQ(result.frame.sequence, last + 1);
    }
    EXPECT_EQ(result.frame.instant, ExposureInstant::kStart);
    EXPECT_LT(Clock::System().monotonic() - result.frame.captured_monotonic, 1s);
    last = result.frame.sequence;
  }
}

TEST_F(AravisFakeTest, FramesOutliveTheSource) {
  auto source = std::make_unique<AravisSource>(Fake());
  ASSERT_EQ(source->Open(), "");
  std::vector<Frame> kept;
  for (int i = 0; i < 8; ++i) {  // every buffer that there is
    CaptureResult result = source->Next(5s);
    ASSERT_EQ(result.status, CaptureStatus::kFrame);
    kept.push_back(std::move(result.frame));
  }
  // None is left for the camera, which is no fault of its.
  EXPECT_EQ(source->Next(700ms).status, CaptureStatus::kTimeout);
  kept.pop_back();
  EXPECT_EQ(source->Next(5s).status, CaptureStatus::kFrame);
  source.reset();
  for (const Frame& frame : kept) EXPECT_GE(*frame.image.row(47), 0);
}

TEST_F(AravisFakeTest, IsInterrupted) {
  AravisSource source(Fake());
  source.Interrupt();
  EXPECT_EQ(source.Next(1h).status, CaptureStatus::kDisconnected);
  AravisOptions options = Fake();
  options.trigger = TriggerKind::kHardware;
  AravisSource triggered(options);
  ASSERT_EQ(triggered.Open(), "");
  EXPECT_THAT(triggered.Describe(), HasSubstr("when triggered"));
  triggered.Interrupt();
  EXPECT_EQ(triggered.Next(1h).status, CaptureStatus::kTimeout);
}

TEST_F(AravisFakeTest, SetsWhatIsConfigured) {
  AravisOptions options = Fake();
  options.camera.pixel_format = "RGB8";
  options.exposure_us = 2000;
  options.gain = 5;
  options.gain_auto = AutoMode::kOff;
  options.binning_x = 1;
  options.binning_y = 1;
  options.offset_x = 10;
  options.camera.settings = {{"GainRaw", std::int64_t{7}, "a"}, {"TestBoolean", true, "b"}};
  AravisSource source(options);
  ASSERT_EQ(source.Open(), "");
  EXPECT_THAT(source.Remarks(), IsEmpty());
  EXPECT_EQ(source.Next(5s).frame.image.format(), PixelFormat::kRgb8);
}

TEST_F(AravisFakeTest, TellsOfARateThatIsRefused) {
  AravisOptions options = Fake();
  options.camera.fps = 5000;
  AravisSource source(options);
  ASSERT_EQ(source.Open(), "");
  ASSERT_EQ(source.Remarks().size(), 1u);
  EXPECT_EQ(source.Remarks().front(), "capture.fps: 5000 frames/s were asked for, the camera gives 1000");
}

TEST_F(AravisFakeTest, SaysWhatItCannotDo) {
  AravisOptions options = Fake();
  options.camera.width = 5000;
  EXPECT_EQ(OpenError(options), "throws capture.width: the camera's Width goes from 1 to 2048");
  options = Fake();
  options.camera.pixel_format = "BGR8";
  EXPECT_THAT(OpenError(options), HasSubstr("throws capture.pixel_format: the camera does not offer BGR8; it offers"));
  options = Fake();
  options.exposure_us = 1;
  EXPECT_THAT(OpenError(options), HasSubstr("throws capture.exposure_us = 1: the camera allows from 10 to"));
  options = Fake();
  options.balance_red = 1.5;
  EXPECT_THAT(OpenError(options), HasSubstr("throws capture.balance_red = 1.5: the camera has no BalanceRatio"));
  options = Fake();
  options.trigger = TriggerKind::kHardware;
  options.trigger_line = "Line9";
  EXPECT_THAT(OpenError(options), HasSubstr("the camera's trigger sources are Line0 or Software"));
  options = Fake();
  options.ptp = true;
  EXPECT_THAT(OpenError(options), HasSubstr("throws capture.ptp = true: the camera has no"));
  options = Fake();
  options.camera.settings = {{"GainRaw", std::int64_t{11}, "place"}};
  EXPECT_EQ(OpenError(options), "throws place: must be a whole number from 0 to 10");
  options.camera.settings = {{"GainAuto", std::string("Sometimes"), "place"}};
  EXPECT_EQ(OpenError(options), "throws place: must be Off, Once or Continuous");
  options.camera.settings = {{"Nothing", true, "place"}};
  EXPECT_THAT(OpenError(options), HasSubstr("throws place: the camera has no such feature"));
}

TEST_F(AravisFakeTest, WaitsForACameraThatIsNotThere) {
  AravisOptions options = Fake();
  options.camera.device = "Nobody-1";
  EXPECT_THAT(OpenError(options), HasSubstr("capture.device: no camera 'Nobody-1' answers"));
}

}  // namespace
}  // namespace chequer
