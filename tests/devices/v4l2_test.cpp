#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>

#include "capture/recording.h"
#include "capture/v4l2_source.h"
#include "devices/camera_test_tools.h"
#include "devices/swarm_truth.h"
#include "integration/workspace.h"
#include "support/process.h"
#include "support/temporary_directory.h"

// Runs in the virtual machine of tests/devices/vm, as root, with the driver vivid as /dev/video0. The machine emulates
// its processor and is some ten times slower than the host.

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
using test::CameraConfig;
using test::DemoRecording;
using test::HasPoses;
using test::Process;
using test::Received;
using test::Subscriber;
using test::SwarmTruth;
using test::TemporaryDirectory;
using test::Waits;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kCamera = "/dev/video0";

V4l2Options CameraAt(const std::string& device) {
  V4l2Options options;
  options.camera.device = device;
  options.camera.fps = 25;
  return options;
}

/// The lines of a configuration's [capture].
std::string Capture(const std::string& lines) { return "source = \"v4l2\"\n" + lines; }

/// Plugs the camera of vivid in or out.
void Plug(bool in) {
  std::ofstream(std::string("/sys/bus/platform/drivers/vivid/") + (in ? "bind" : "unbind")) << "vivid.0";
}

void LoadLoop(const std::string& number) {
  Process insmod({"insmod", "/tmp/mods/v4l2loopback.ko", "video_nr=" + number, "card_label=loop", "exclusive_caps=0",
                  "max_buffers=8"});
  ASSERT_EQ(insmod.Wait(), 0) << insmod.output();
}

void UnloadLoop() {
  Process rmmod({"rmmod", "v4l2loopback"});
  ASSERT_EQ(rmmod.Wait(), 0) << rmmod.output();
}

std::unique_ptr<Process> StartFeeder(const std::string& device, bool as_jpeg = false) {
  std::vector<std::string> command{V4L2_FEEDER, device, DemoRecording().string(), as_jpeg ? "15" : "60"};
  if (as_jpeg) command.push_back("MJPEG");
  auto feeder = std::make_unique<Process>(command);
  EXPECT_TRUE(feeder->WaitForOutput("feeding", seconds(60))) << feeder->output();
  return feeder;
}

class V4l2Test : public ::testing::Test {
 protected:
  std::string Configure(const std::string& capture, const std::filesystem::path& calibration = {}) const {
    return CameraConfig(folder_.path(), Capture(capture), calibration);
  }

  /// A frame of eight markers takes half a second in the machine, more where others compile.
  bool ReceiveUntil(const std::function<bool(const Received&)>& condition) {
    return subscriber_.ReceiveUntil(condition, seconds(120));
  }

  TemporaryDirectory folder_;
  Subscriber subscriber_;
};

TEST_F(V4l2Test, EveryOfferedFormatStreams) {
  const std::vector<V4l2FormatOffer> offers = QueryFormats(V4l2Device(kCamera));
  int streamed = 0;
  for (const V4l2FormatOffer& offer : offers) {
    const std::string name = NameOfFourCc(offer.code);
    if (name.empty()) continue;
    SCOPED_TRACE(name);
    V4l2Options options = CameraAt(kCamera);
    options.camera.pixel_format = name;
    options.camera.width = offer.sizes.front().max_width;
    options.camera.height = offer.sizes.front().max_height;
    // The other source of vivid's stamps, the end of a frame, lies in the future.
    options.camera.settings = {{"timestamp_source", std::string("start of exposure"), "test"}};
    V4l2Source source(options);
    ASSERT_EQ(source.Open(), "");
    EXPECT_THAT(source.Remarks(), IsEmpty());
    // Now and then vivid itself is late on a busy machine, and skips a number. A gap of ours would come again and
    // again.
    std::uint64_t last = 0;
    MonotonicTime last_time{};
    int in_a_row = 0;
    for (int i = 0; i < 60 && in_a_row < 8; ++i) {
      const CaptureResult result = source.Next(seconds(10));
      ASSERT_EQ(result.status, CaptureStatus::kFrame) << result.message;
      EXPECT_EQ(result.frame.image.width(), options.camera.width);
      EXPECT_EQ(PixelFormatName(result.frame.image.format()), name);
      EXPECT_GT(result.frame.captured_monotonic, last_time);
      EXPECT_EQ(result.frame.instant, ExposureInstant::kStart);
      EXPECT_LT(Clock::System().monotonic() - result.frame.captured_monotonic, seconds(1));
      in_a_row = i == 0 || result.frame.sequence == last + 1 ? in_a_row + 1 : 0;
      last = result.frame.sequence;
      last_time = result.frame.captured_monotonic;
    }
    EXPECT_EQ(in_a_row, 8);
    ++streamed;
  }
  EXPECT_GE(streamed, 10);  // of vivid: four Bayer, RGB and BGR, YUYV and UYVY, NV12, grey
}

TEST_F(V4l2Test, FramesKeepTheirBuffersAndOutliveTheSource) {
  auto source = std::make_unique<V4l2Source>(CameraAt(kCamera));
  ASSERT_EQ(source->Open(), "");
  std::vector<Frame> kept;
  // More than the driver has buffers: the last are copies, and nothing stands still.
  for (int i = 0; i < 12; ++i) {
    CaptureResult result = source->Next(seconds(10));
    ASSERT_EQ(result.status, CaptureStatus::kFrame) << result.message;
    kept.push_back(std::move(result.frame));
  }
  source.reset();
  int sum = 0;
  for (const Frame& frame : kept) sum += *frame.image.row(frame.image.height() - 1);
  EXPECT_GT(sum, 0);
  kept.clear();
  V4l2Source again(CameraAt(kCamera));
  EXPECT_EQ(again.Open(), "");
}

TEST_F(V4l2Test, SetsControlsAndTellsWhatTheDriverMadeOfThem) {
  V4l2Options options = CameraAt(kCamera);
  options.camera.settings = {{"brightness", std::int64_t{77}, "a"},
                             {"gain", std::int64_t{30}, "b"},
                             {"gain_automatic", false, "c"},
                             {"horizontal_flip", true, "d"}};
  V4l2Source source(options);
  ASSERT_EQ(source.Open(), "");
  EXPECT_THAT(source.Remarks(), IsEmpty());
  const V4l2Device device(kCamera);
  std::map<std::string, V4l2ControlValue> values;
  for (const V4l2Control& control : QueryControls(device))
    if (const auto value = GetControl(device, control)) values[control.name] = *value;
  EXPECT_EQ(values["brightness"], V4l2ControlValue(std::int64_t{77}));
  EXPECT_EQ(values["gain_automatic"], V4l2ControlValue(std::int64_t{0}));
  EXPECT_EQ(values["gain"], V4l2ControlValue(std::int64_t{30}));
}

TEST_F(V4l2Test, GoesOnWithTheRateThatTheCameraGives) {
  Process daemon({CHEQUERD, "--config", Configure("device = \"/dev/video0\"\nwidth = 640\nheight = 480\nfps = 60")});
  EXPECT_TRUE(daemon.WaitForOutput("60 frames/s were asked for, the camera gives")) << daemon.output();
  EXPECT_TRUE(ReceiveUntil(HasPoses(10)));
}

TEST_F(V4l2Test, FramesFlowAgainAfterUnplugging) {
  Process daemon({CHEQUERD, "--config", Configure("device = \"/dev/video0\"\nwidth = 320\nheight = 180\nfps = 25")});
  ASSERT_TRUE(ReceiveUntil(HasPoses(10)));
  const auto unplugged = steady_clock::now();
  Plug(false);
  ASSERT_TRUE(daemon.WaitForOutput("the camera was lost")) << daemon.output();
  EXPECT_LT(steady_clock::now() - unplugged, milliseconds(1500));
  ASSERT_TRUE(ReceiveUntil(Waits));
  std::size_t before = subscriber_.received().poses.size();
  Plug(true);
  const auto plugged = steady_clock::now();
  ASSERT_TRUE(ReceiveUntil(HasPoses(before + 1)));
  EXPECT_LT(steady_clock::now() - plugged, seconds(3));

  // Another device takes its number meanwhile: it must be found under the new one, and the other be left alone.
  Plug(false);
  ASSERT_TRUE(ReceiveUntil(Waits));
  LoadLoop("0");
  before = subscriber_.received().poses.size();
  Plug(true);
  EXPECT_TRUE(ReceiveUntil(HasPoses(before + 5)));
  EXPECT_TRUE(ReceiveUntil([](const Received& got) {
    return got.statuses.back().camera_source.find("/dev/video1 (vivid") != std::string::npos;
  })) << subscriber_.received().statuses.back().camera_source;
  const std::vector<PosesMessage>& poses = subscriber_.received().poses;
  for (std::size_t i = 1; i < poses.size(); ++i) EXPECT_GT(poses[i].sequence, poses[i - 1].sequence);
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0) << daemon.output();
  Plug(false);
  UnloadLoop();
  Plug(true);
}

TEST_F(V4l2Test, PosesOfAFedSwarmAreRightAlsoAfterTheFeederDied) {
  LoadLoop("10");
  const SwarmTruth truth(DemoRecording());
  auto feeder = StartFeeder("/dev/video10");
  // The loop knows no rate of its own.
  Process daemon(
      {CHEQUERD, "--config", Configure("device = \"/dev/video10\"\nfps = 60", DemoRecording() / "camera.toml")});
  ASSERT_TRUE(ReceiveUntil(HasPoses(30))) << daemon.output();
  // What was in the loop before the feeder is of no frame.
  const auto expect_right = [&](std::size_t from) {
    for (std::size_t i = from; i < subscriber_.received().poses.size(); ++i)
      EXPECT_EQ(truth.Judge(subscriber_.received().poses[i]), "");
  };
  expect_right(1);
  feeder->Signal(SIGKILL);
  feeder->Wait();
  ASSERT_TRUE(ReceiveUntil(Waits)) << daemon.output();
  EXPECT_TRUE(daemon.WaitForOutput("the camera was lost: /dev/video10 (loop): no frame for 0.")) << daemon.output();
  const std::size_t before = subscriber_.received().poses.size();
  feeder = StartFeeder("/dev/video10");
  ASSERT_TRUE(ReceiveUntil(HasPoses(before + 15))) << daemon.output();
  expect_right(before + 1);
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0) << daemon.output();
  feeder.reset();
  UnloadLoop();
}

TEST_F(V4l2Test, PosesAreRightInJpegs) {
  LoadLoop("10");
  const SwarmTruth truth(DemoRecording());
  auto feeder = StartFeeder("/dev/video10", true);
  Process daemon({CHEQUERD, "--config",
                  Configure("device = \"loop\"\nfps = 15\npixel_format = \"MJPEG\"", DemoRecording() / "camera.toml")});
  ASSERT_TRUE(ReceiveUntil(HasPoses(12))) << daemon.output();
  for (std::size_t i = 1; i < 12; ++i) EXPECT_EQ(truth.Judge(subscriber_.received().poses[i]), "");
  EXPECT_EQ(subscriber_.received().poses.back().image_width, 640);
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0) << daemon.output();
  feeder.reset();
  UnloadLoop();
}

/// What the daemon says before it ends with status 78.
std::string Refusal(const std::string& config, std::vector<std::string> command = {}) {
  command.insert(command.end(), {CHEQUERD, "--config", config});
  Process daemon(command);
  EXPECT_EQ(daemon.Wait(), 78) << daemon.output();
  return daemon.output();
}

TEST_F(V4l2Test, EndsWhereWaitingCannotHelp) {
  const std::string camera = "device = \"/dev/video0\"\n";
  EXPECT_THAT(Refusal(Configure(camera + "pixel_format = \"MJPEG\"")),
              AllOf(HasSubstr("capture.pixel_format = 'MJPEG'"), HasSubstr("does not offer MJPEG; it offers"),
                    HasSubstr("YUYV")));
  EXPECT_THAT(Refusal(Configure(camera + "pixel_format = \"YUYV\"\nwidth = 641\nheight = 480")),
              AllOf(HasSubstr("capture.width = 641"), HasSubstr("does not offer 641x480"), HasSubstr("640x480")));
  EXPECT_THAT(Refusal(Configure(camera + "[capture.controls]\nbrightness = 256")),
              AllOf(HasSubstr("test.toml:"), HasSubstr("brightness = 256: must be from 0 to 255")));
  EXPECT_THAT(Refusal(Configure(camera + "[capture.controls]\nbrighness = 1")),
              AllOf(HasSubstr("no such control"), HasSubstr("brightness")));
  std::filesystem::permissions(folder_.path(), std::filesystem::perms::all);
  EXPECT_THAT(Refusal(Configure(camera), {"setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"}),
              AllOf(HasSubstr("Permission denied"), HasSubstr("usermod -aG video")));
}

TEST_F(V4l2Test, WaitsWhereWaitingCanHelp) {
  {
    Process daemon({CHEQUERD, "--config", Configure("device = \"/dev/video7\"")});
    EXPECT_TRUE(daemon.WaitForOutput("no camera '/dev/video7' is there; there are /dev/video0 (vivid"))
        << daemon.output();
    EXPECT_TRUE(daemon.IsRunning());
  }
  V4l2Source user(CameraAt(kCamera));
  ASSERT_EQ(user.Open(), "");
  Process daemon({CHEQUERD, "--config", Configure("device = \"/dev/video0\"")});
  EXPECT_TRUE(daemon.WaitForOutput("another program uses the camera")) << daemon.output();
  EXPECT_TRUE(daemon.IsRunning());
}

TEST_F(V4l2Test, FramesAreHandedOverInTheDriversBuffers) {
  V4l2Options options = CameraAt(kCamera);
  options.camera.pixel_format = "YUYV";
  options.camera.width = 1920;
  options.camera.height = 1080;
  V4l2Source source(options);
  ASSERT_EQ(source.Open(), "");
  const test::CaptureCost cost = test::MeasureCapture(source, 20);
  EXPECT_EQ(cost.problem, "");
  std::printf("1920x1080: %.3f ms of processor a frame (%.3f ms outside of the kernel), handed over in %.3f ms\n",
              cost.cpu_ms, cost.user_ms, cost.hand_over_ms);
  EXPECT_LE(cost.places, options.camera.buffers);  // nothing is copied
}

TEST_F(V4l2Test, RecordsAndListsTheCamera) {
  const std::filesystem::path out = folder_ / "recorded";
  Process record({CHEQUER, "record", "--device", kCamera, "--size", "320x180", "--pixel-format", "YUYV", "--fps", "25",
                  "--frames", "10", "--set", "brightness=100", "--out", out.string()});
  ASSERT_EQ(record.Wait(seconds(60)), 0) << record.output();
  const Recording recording = OpenRecording(out);
  EXPECT_EQ(recording.frames.size(), 10u);
  EXPECT_EQ(recording.info.pixel_format, PixelFormat::kYuyv);
  Process snapshot({CHEQUER, "snapshot", "--device", kCamera, "--size", "320x180", "--skip", "0", "--out",
                    (folder_ / "now.jpg").string()});
  EXPECT_EQ(snapshot.Wait(seconds(60)), 0) << snapshot.output();
  Process cameras({CHEQUER, "cameras"});
  EXPECT_EQ(cameras.Wait(seconds(60)), 0);
  EXPECT_THAT(cameras.output(), AllOf(HasSubstr("device = \"/dev/video0\""), HasSubstr("pixel_format = \"YUYV\""),
                                      HasSubstr("640x480"), HasSubstr("brightness: from 0 to 255; is 100")));
}

}  // namespace
}  // namespace chequer
