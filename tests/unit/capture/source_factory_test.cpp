#include "capture/source_factory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "capture_text.h"
#include "small_recording.h"
#include "support/manual_clock.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

using namespace std::chrono_literals;
using test::ReadCapture;
using test::ReadCaptureError;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ReadCaptureOptions, ReadsEveryKey) {
  const CaptureOptions options = ReadCapture(R"(
    source = "replay"
    path = "swarm"
    fps = 12.5
    one_channel = "BayerGB8"
    gamma = 1
    pace = "fixed"
    replay_fps = 60
    loop = true
    preload = "yes"
    preload_limit_mb = 3
    times = "recorded"
    faults = ["drop 1 2"])");
  EXPECT_EQ(options.source, SourceKind::kReplay);
  EXPECT_EQ(options.replay.path, "/data/swarm");
  EXPECT_EQ(options.replay.plain.fps, 12.5);
  EXPECT_EQ(options.replay.plain.one_channel, PixelFormat::kBayerGb8);
  EXPECT_EQ(options.replay.plain.tone_curve, ToneCurve::Linear());
  EXPECT_EQ(options.replay.pace, ReplayPace::kFixedRate);
  EXPECT_EQ(options.replay.fps, 60);
  EXPECT_TRUE(options.replay.loop);
  EXPECT_EQ(options.replay.preload, Preload::kYes);
  EXPECT_EQ(options.replay.preload_limit_bytes, 3u << 20);
  EXPECT_EQ(options.replay.times, ReplayTimes::kRecorded);
  EXPECT_THAT(options.faults, ElementsAre("drop 1 2"));
}

TEST(ReadCaptureOptions, HasTheDefaultsOfTheStructs) {
  const CaptureOptions options = ReadCapture("images = ['a.png', '/b.png']");
  EXPECT_THAT(options.replay.images, ElementsAre("/data/a.png", "/b.png"));
  const ReplayOptions defaults;
  EXPECT_EQ(options.replay.pace, defaults.pace);
  EXPECT_EQ(options.replay.fps, defaults.fps);
  EXPECT_EQ(options.replay.loop, defaults.loop);
  EXPECT_EQ(options.replay.preload, defaults.preload);
  EXPECT_EQ(options.replay.preload_limit_bytes, defaults.preload_limit_bytes);
  EXPECT_EQ(options.replay.times, defaults.times);
  EXPECT_EQ(options.replay.plain.fps, defaults.plain.fps);
  EXPECT_EQ(options.replay.plain.one_channel, PixelFormat::kMono8);
  EXPECT_TRUE(options.replay.plain.tone_curve.is_srgb());
  EXPECT_TRUE(options.faults.empty());
}

TEST(ReadCaptureOptions, SaysWhatWouldBeRight) {
  EXPECT_THAT(ReadCaptureError(""), HasSubstr("swarm.toml:1: capture.path: is missing: must be a recording"));
  EXPECT_THAT(ReadCaptureError("path = 'x'\nimages = ['y']"), HasSubstr("swarm.toml:3: capture.images = "));
  EXPECT_THAT(ReadCaptureError("path = 'x'\nsource = 'usb'"),
              HasSubstr("swarm.toml:3: capture.source = 'usb': must be \"replay\", \"v4l2\" or \"aravis\""));
  EXPECT_THAT(ReadCaptureError("path = 'x'\npace = 'slow'"),
              HasSubstr("capture.pace = 'slow': must be \"recorded\", \"fixed\" or \"unlimited\""));
  EXPECT_THAT(ReadCaptureError("path = 'x'\nfps = 0"), HasSubstr("capture.fps = 0: must be from 0.001 to 10000"));
  EXPECT_THAT(ReadCaptureError("path = 'x'\nreplay_fps = -1"), HasSubstr("capture.replay_fps = -1: must be from"));
  EXPECT_THAT(ReadCaptureError("path = 'x'\none_channel = 'BGR8'"),
              HasSubstr("capture.one_channel = 'BGR8': must be \"Mono8\""));
  EXPECT_THAT(ReadCaptureError("path = 'x'\ngamma = 0"), HasSubstr("capture.gamma = 0: must be from 0.2 to 5"));
  EXPECT_THAT(ReadCaptureError("path = 'x'\npreload = true"), HasSubstr("must be \"auto\", \"yes\" or \"no\""));
  EXPECT_THAT(ReadCaptureError("path = 'x'\npreload_limit_mb = 0"), HasSubstr("must be from 1 to 65536"));
  EXPECT_THAT(ReadCaptureError("path = 'x'\nloop = 1"), HasSubstr("must be true or false"));
  EXPECT_THAT(ReadCaptureError("path = 'x'\ntimes = 'mine'"), HasSubstr("must be \"played\" or \"recorded\""));
  EXPECT_THAT(ReadCaptureError("path = 'x'\nfaults = ['melt 3']"),
              HasSubstr("swarm.toml:3: capture.faults = ['melt 3']: fault \"melt 3\": must be"));
}

TEST(MakeSource, PlaysWithFaults) {
  const test::TemporaryDirectory folder;
  test::WriteSmallRecording(folder.path(), 3);
  CaptureOptions options;
  options.replay.path = folder.path();
  options.faults = {"drop 0 1"};
  const auto source = MakeSource(options, std::make_shared<test::ManualClock>());
  ASSERT_EQ(source->Open(), "");
  EXPECT_EQ(source->Next(1s).frame.sequence, 101u);
  options.faults.clear();
  const auto plain = MakeSource(options);
  ASSERT_EQ(plain->Open(), "");
  EXPECT_EQ(plain->Next(1s).frame.sequence, 100u);
}

TEST(MakeSource, RefusesOptionsThatCannotBe) { EXPECT_THROW(MakeSource(CaptureOptions{}), std::runtime_error); }

}  // namespace
}  // namespace chequer
