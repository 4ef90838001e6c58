#include "capture/camera_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "capture_text.h"

namespace chequer {
namespace {

using ::testing::HasSubstr;

using test::ReadCapture;
using test::ReadCaptureError;

TEST(CameraConfig, ReadsEveryKeyOfV4l2) {
  const V4l2Options options = ReadCapture(R"(source = "v4l2"
    device = "/dev/video3"
    pixel_format = "MJPEG"
    width = 1280
    height = 720
    fps = 50
    buffers = 6
    gamma = 1
    yuv_range = "limited"
    input = 2
    [capture.controls]
    white_balance_automatic = false
    gain = 7
    power_line_frequency = "50 Hz")")
                                  .v4l2;
  const CameraOptions& camera = options.camera;
  EXPECT_EQ(camera.device, "/dev/video3");
  EXPECT_EQ(camera.pixel_format, "MJPEG");
  EXPECT_EQ(camera.width, 1280);
  EXPECT_EQ(camera.height, 720);
  EXPECT_EQ(camera.fps, 50);
  EXPECT_EQ(camera.buffers, 6);
  EXPECT_EQ(camera.tone_curve, ToneCurve::Linear());
  EXPECT_EQ(options.yuv_range, YuvRange::kLimited);
  EXPECT_EQ(options.input, 2);
  ASSERT_EQ(camera.settings.size(), 3u);
  // In the order in which they are written.
  EXPECT_EQ(camera.settings[0].name, "white_balance_automatic");
  EXPECT_EQ(camera.settings[0].value, CameraSetting::Value(false));
  EXPECT_EQ(camera.settings[1].value, CameraSetting::Value(std::int64_t{7}));
  EXPECT_EQ(camera.settings[1].place, "swarm.toml:14: capture.controls.gain = 7");
  EXPECT_EQ(camera.settings[2].value, CameraSetting::Value(std::string("50 Hz")));
  EXPECT_EQ(camera.places.device, "swarm.toml:3: capture.device = '/dev/video3'");
}

TEST(CameraConfig, ReadsEveryKeyOfAravis) {
  const AravisOptions options = ReadCapture(R"(source = "aravis"
    device = "12345"
    pixel_format = "BayerRG8"
    offset_x = 8
    offset_y = 4
    binning_x = 2
    binning_y = 2
    exposure_us = 5000.5
    exposure_auto = "off"
    gain = 3.5
    gain_auto = "once"
    white_balance_auto = "continuous"
    balance_red = 1.5
    balance_blue = 2
    trigger = "hardware"
    trigger_line = "Line2"
    packet_size = 1500
    packet_resend = false
    ptp = true
    features.Gamma = 0.5)")
                                    .aravis;
  EXPECT_EQ(options.camera.device, "12345");
  EXPECT_EQ(options.offset_x, 8);
  EXPECT_EQ(options.offset_y, 4);
  EXPECT_EQ(options.binning_x, 2);
  EXPECT_EQ(options.binning_y, 2);
  EXPECT_EQ(options.exposure_us, 5000.5);
  EXPECT_EQ(options.exposure_auto, AutoMode::kOff);
  EXPECT_EQ(options.gain, 3.5);
  EXPECT_EQ(options.gain_auto, AutoMode::kOnce);
  EXPECT_EQ(options.white_balance_auto, AutoMode::kContinuous);
  EXPECT_EQ(options.balance_red, 1.5);
  EXPECT_EQ(options.balance_blue, 2);
  EXPECT_EQ(options.trigger, TriggerKind::kHardware);
  EXPECT_EQ(options.trigger_line, "Line2");
  EXPECT_EQ(options.packet_size, 1500);
  EXPECT_FALSE(options.packet_resend);
  EXPECT_TRUE(options.ptp);
  ASSERT_EQ(options.camera.settings.size(), 1u);
  EXPECT_EQ(options.camera.settings[0].value, CameraSetting::Value(0.5));
}

TEST(CameraConfig, SaysWhatWouldBeRight) {
  EXPECT_THAT(ReadCaptureError("source = 'v4l2'\npixel_format = 'JPG'"),
              HasSubstr("must be one of MJPEG, Mono8, BGR8"));
  EXPECT_THAT(ReadCaptureError("source = 'aravis'\npixel_format = 'MJPEG'"), HasSubstr("give no JPEGs"));
  EXPECT_THAT(ReadCaptureError("source = 'v4l2'\nwidth = 640"),
              HasSubstr("capture.height: is missing: a size needs both"));
  EXPECT_THAT(ReadCaptureError("source = 'v4l2'\nbuffers = 1"), HasSubstr("must be from 2 to 32"));
  EXPECT_THAT(ReadCaptureError("source = 'v4l2'\nexposure_us = 3"),
              HasSubstr("capture.exposure_us: unknown key with source = \"v4l2\"; it is for source = \"aravis\""));
  EXPECT_THAT(ReadCaptureError("source = 'aravis'\nyuv_range = 'full'"), HasSubstr("capture.yuv_range: unknown key"));
  EXPECT_THAT(ReadCaptureError("source = 'aravis'\npath = 'x'"), HasSubstr("capture.path: unknown key"));
  EXPECT_THAT(ReadCaptureError("source = 'aravis'\ntrigger = 'now'"),
              HasSubstr("must be \"free\", \"software\" or \"hardware\""));
  EXPECT_THAT(ReadCaptureError("source = 'v4l2'\ncontrols = 3"),
              HasSubstr("must be a table, written [capture.controls]"));
  EXPECT_THAT(ReadCaptureError("source = 'v4l2'\ncontrols.gain = [1]"),
              HasSubstr("must be a number, a text in quotes, true or false"));
}

}  // namespace
}  // namespace chequer
