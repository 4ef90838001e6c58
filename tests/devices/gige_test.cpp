#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "capture/aravis_source.h"
#include "capture/recording.h"
#include "devices/camera_test_tools.h"
#include "devices/swarm_truth.h"
#include "integration/workspace.h"
#include "support/process.h"
#include "support/temporary_directory.h"

// chequerd against a camera of GigE Vision that another process serves over the loopback of a private network.

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
using test::CameraConfig;
using test::HasPoses;
using test::Holdings;
using test::HoldingsOf;
using test::Process;
using test::Received;
using test::Subscriber;
using test::SwarmTruth;
using test::TemporaryDirectory;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// A swarm as a camera of 1280 x 1024 sees it, rendered once.
class GigeTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryDirectory>();
    Process render({CHEQUER,      "render", "--size",   "1280x1024",     "--frames",  "6",      "--swarm", "8",
                    "--distance", "1.5",    "--marker", "6x6",           "--variant", "secded", "--side",  "0.12",
                    "--fps",      "5",      "--out",    Swarm().string()});
    ASSERT_EQ(render.Wait(seconds(100)), 0) << render.output();
    truth_ = std::make_unique<SwarmTruth>(Swarm());
  }
  static void TearDownTestSuite() {
    truth_.reset();
    folder_.reset();
  }

  static std::filesystem::path Swarm() { return *folder_ / "swarm"; }
  static std::filesystem::path Calibration() { return Swarm() / "camera.toml"; }

  static std::unique_ptr<Process> StartCamera(const std::string& address, const std::string& serial,
                                              const std::string& lost = "0") {
    auto camera =
        std::make_unique<Process>(std::vector<std::string>{GIGE_CAMERA, address, serial, Swarm().string(), lost});
    EXPECT_TRUE(camera->WaitForOutput("is up")) << camera->output();
    return camera;
  }

  static std::string Configure(const std::string& capture, const std::string& name = "test") {
    return CameraConfig(folder_->path(), "source = \"aravis\"\n" + capture, Calibration(), name);
  }

  /// The last messages are right.
  static void ExpectRight(const Received& got, std::size_t last) {
    ASSERT_GE(got.poses.size(), last);
    for (std::size_t i = got.poses.size() - last; i < got.poses.size(); ++i) EXPECT_EQ(truth_->Judge(got.poses[i]), "");
  }

  static std::unique_ptr<TemporaryDirectory> folder_;
  static std::unique_ptr<SwarmTruth> truth_;
};

std::unique_ptr<TemporaryDirectory> GigeTest::folder_;
std::unique_ptr<SwarmTruth> GigeTest::truth_;

TEST_F(GigeTest, PosesAreRightInBayerAndRgb) {
  const auto camera = StartCamera("127.0.0.1", "GV01");
  for (const char* format : {"BayerRG8", "RGB8"}) {
    Subscriber subscriber;
    Process daemon({CHEQUERD, "--config", Configure(std::string("fps = 15\npixel_format = \"") + format + "\"")});
    ASSERT_TRUE(subscriber.ReceiveUntil(HasPoses(20))) << daemon.output();
    ExpectRight(subscriber.received(), 20);
    const PosesMessage& last = subscriber.received().poses.back();
    EXPECT_EQ(last.instant, ExposureInstant::kStart);
    EXPECT_LE(last.captured_monotonic, last.published_monotonic);
    EXPECT_LT(last.published_monotonic - last.captured_monotonic, seconds(2));
    ASSERT_TRUE(subscriber.ReceiveUntil([&](const Received& got) {
      return !got.statuses.empty() && got.statuses.back().camera_source.find(format) != std::string::npos;
    })) << daemon.output();
    EXPECT_THAT(subscriber.received().statuses.back().camera_source, HasSubstr("1280x1024"));
    daemon.Signal(SIGTERM);
    EXPECT_EQ(daemon.Wait(), 0) << daemon.output();
  }
}

TEST_F(GigeTest, SurvivesACameraThatIsKilledFiveTimes) {
  auto camera = StartCamera("127.0.0.1", "GV01");
  Subscriber subscriber;
  Process daemon({CHEQUERD, "--config", Configure("fps = 15\npixel_format = \"BayerRG8\"")});
  ASSERT_TRUE(subscriber.ReceiveUntil(HasPoses(10))) << daemon.output();
  Holdings first;
  for (int round = 0; round < 5; ++round) {
    camera->Signal(SIGKILL);
    camera->Wait();
    ASSERT_TRUE(daemon.WaitForOutput("the camera was lost")) << daemon.output();
    const std::size_t before = subscriber.received().poses.size();
    camera = StartCamera("127.0.0.1", "GV01");
    const auto returned = steady_clock::now();
    ASSERT_TRUE(subscriber.ReceiveUntil(HasPoses(before + 3))) << daemon.output();
    EXPECT_LT(steady_clock::now() - returned, seconds(4)) << daemon.output();
    ExpectRight(subscriber.received(), 2);
    // What libraries make once they have made in the first round.
    if (round == 0) first = HoldingsOf(daemon.pid());
  }
  const Holdings last = HoldingsOf(daemon.pid());
  EXPECT_LE(last.descriptors, first.descriptors) << daemon.output();
  EXPECT_LE(last.threads, first.threads);
  EXPECT_LE(last.memory_kb, first.memory_kb + first.memory_kb / 10);
  EXPECT_TRUE(subscriber.ReceiveUntil([](const Received& got) { return got.Dropped("lost_before") >= 5 * 7; }));
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0);
  const std::vector<PosesMessage>& poses = subscriber.received().poses;
  int gaps = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    EXPECT_GT(poses[i].sequence, poses[i - 1].sequence);
    gaps += poses[i].sequence > poses[i - 1].sequence + 7 ? 1 : 0;  // half a second
  }
  EXPECT_EQ(gaps, 5);
}

TEST_F(GigeTest, TwoCamerasAtOnce) {
  Process ip({"ip", "address", "add", "127.0.0.2/8", "dev", "lo"});
  ASSERT_EQ(ip.Wait(), 0) << ip.output();
  const auto left = StartCamera("127.0.0.1", "LEFT");
  const auto right = StartCamera("127.0.0.2", "RIGHT");
  Subscriber subscriber;
  Process left_daemon({CHEQUERD, "--config", Configure("fps = 10\ndevice = \"LEFT\"", "left")});
  Process right_daemon({CHEQUERD, "--config", Configure("fps = 10\ndevice = \"127.0.0.2\"", "right")});
  const auto both = [](const Received& got) {
    const auto count = [&](const std::string& name) {
      return std::count_if(got.poses.begin(), got.poses.end(),
                           [&](const PosesMessage& poses) { return poses.camera == name; });
    };
    return count("left") >= 10 && count("right") >= 10;
  };
  ASSERT_TRUE(subscriber.ReceiveUntil(both)) << left_daemon.output() << right_daemon.output();
  ExpectRight(subscriber.received(), 20);
}

TEST_F(GigeTest, WaitsForTheCameraAtTheStart) {
  Subscriber subscriber;
  Process daemon({CHEQUERD, "--config", Configure("fps = 15\ndevice = \"GV01\"")});
  ASSERT_TRUE(daemon.WaitForOutput("capture.device = 'GV01': no camera 'GV01' answers")) << daemon.output();
  const auto camera = StartCamera("127.0.0.1", "GV01");
  EXPECT_TRUE(subscriber.ReceiveUntil(HasPoses(3))) << daemon.output();
  ExpectRight(subscriber.received(), 1);
}

TEST_F(GigeTest, NoticesACameraThatFallsSilent) {
  const auto camera = StartCamera("127.0.0.1", "GV01");
  Subscriber subscriber;
  Process daemon({CHEQUERD, "--config", Configure("fps = 15")});
  ASSERT_TRUE(subscriber.ReceiveUntil(HasPoses(5))) << daemon.output();
  camera->Signal(SIGSTOP);
  const auto silent = steady_clock::now();
  EXPECT_TRUE(daemon.WaitForOutput("the camera was lost: Aravis-Fake-GV01: no frame for 0.5 s")) << daemon.output();
  EXPECT_LT(steady_clock::now() - silent, seconds(2));
  const std::size_t before = subscriber.received().poses.size();
  camera->Signal(SIGCONT);
  EXPECT_TRUE(subscriber.ReceiveUntil(HasPoses(before + 3))) << daemon.output();
  // Ending does not wait for a camera to hear that nobody wants it any more.
  camera->Signal(SIGSTOP);
  const auto asked = steady_clock::now();
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0) << daemon.output();
  EXPECT_LT(steady_clock::now() - asked, milliseconds(2500));
  camera->Signal(SIGCONT);
}

TEST_F(GigeTest, CountsIncompleteFramesAndNeverUsesThem) {
  // So few packets are lost that about half of the frames of 940 are whole.
  const auto camera = StartCamera("127.0.0.1", "GV01", "0.0007");
  Subscriber subscriber;
  Process daemon({CHEQUERD, "--config", Configure("fps = 15\npixel_format = \"BayerRG8\"")});
  ASSERT_TRUE(subscriber.ReceiveUntil([](const Received& got) {
    return got.poses.size() >= 15 && !got.statuses.empty() && got.Dropped("corrupt") >= 3;
  })) << daemon.output();
  ExpectRight(subscriber.received(), subscriber.received().poses.size());
  EXPECT_TRUE(daemon.WaitForOutput("a frame is unusable: frame")) << daemon.output();
  EXPECT_TRUE(subscriber.ReceiveUntil([](const Received& got) {
    return got.statuses.back().camera_source.find("packets missing") != std::string::npos;
  }));
}

TEST_F(GigeTest, TakesFramesOnCommand) {
  const auto camera = StartCamera("127.0.0.1", "GV01");
  Subscriber subscriber;
  Process daemon({CHEQUERD, "--config", Configure("fps = 8\ntrigger = \"software\"")});
  ASSERT_TRUE(subscriber.ReceiveUntil(HasPoses(10))) << daemon.output();
  ExpectRight(subscriber.received(), 10);
}

TEST_F(GigeTest, EndsWhereWaitingCannotHelp) {
  const auto camera = StartCamera("127.0.0.1", "GV01");
  const auto refusal = [&](const std::string& capture) {
    Process daemon({CHEQUERD, "--config", Configure(capture)});
    EXPECT_EQ(daemon.Wait(), 78) << daemon.output();
    return daemon.output();
  };
  EXPECT_THAT(refusal("[capture.features]\nGainRaw = 11"),
              HasSubstr("capture.features.GainRaw = 11: must be a whole number from 0 to 10"));
  EXPECT_THAT(refusal("width = 4000\nheight = 100"), HasSubstr("the camera's Width goes from 1 to 2048"));
}

TEST_F(GigeTest, LeavesACameraToTheProgramThatHasIt) {
  const auto camera = StartCamera("127.0.0.1", "GV01");
  Subscriber subscriber;
  Process first({CHEQUERD, "--config", Configure("fps = 15", "first")});
  ASSERT_TRUE(subscriber.ReceiveUntil(HasPoses(3))) << first.output();
  Process second({CHEQUERD, "--config", Configure("fps = 15", "second")});
  EXPECT_TRUE(second.WaitForOutput("another program controls the camera")) << second.output();
  EXPECT_TRUE(second.IsRunning());
  const std::size_t before = subscriber.received().poses.size();
  EXPECT_TRUE(subscriber.ReceiveUntil(HasPoses(before + 10)));
}

TEST_F(GigeTest, RecordsWithTheCamerasOwnTimesAndFormat) {
  const auto camera = StartCamera("127.0.0.1", "GV01");
  const std::filesystem::path out = *folder_ / "recorded", straight = *folder_ / "straight";
  Process record({CHEQUER, "record", "--device", "GV01", "--fps", "10", "--frames", "8", "--pixel-format", "BayerRG8",
                  "--calibration", Calibration().string(), "--undistorted", straight.string(), "--out", out.string()});
  ASSERT_EQ(record.Wait(seconds(60)), 0) << record.output();
  EXPECT_THAT(record.output(), HasSubstr("8 frames"));
  const Recording recording = OpenRecording(out);
  EXPECT_EQ(recording.frames.size(), 8u);
  EXPECT_EQ(recording.info.pixel_format, PixelFormat::kBayerRg8);
  EXPECT_EQ(recording.info.fps, 10);
  EXPECT_EQ(LoadFrame(recording, 7).height(), 1024);
  EXPECT_EQ(OpenRecording(straight).frames.back().captured_utc, recording.frames.back().captured_utc);
  const std::filesystem::path picture = *folder_ / "now.png";
  Process snapshot({CHEQUER, "snapshot", "--device", "GV01", "--skip", "1", "--out", picture.string()});
  EXPECT_EQ(snapshot.Wait(seconds(60)), 0) << snapshot.output();
  EXPECT_EQ(LoadImage(picture).format(), PixelFormat::kBgr8);
  Process cameras({CHEQUER, "cameras"});
  EXPECT_EQ(cameras.Wait(), 0);
  EXPECT_THAT(cameras.output(), AllOf(HasSubstr("device = \"Aravis-Fake-GV01\""), HasSubstr("BayerRG8"),
                                      HasSubstr("GainRaw: a whole number from 0 to 10")));
}

TEST_F(GigeTest, FramesAreHandedOverInTheirBuffers) {
  const auto camera = StartCamera("127.0.0.1", "GV01");
  AravisOptions options;
  options.camera.device = "GV01";
  options.camera.pixel_format = "BayerRG8";
  options.camera.width = 1920;
  options.camera.height = 1080;
  AravisSource source(options);
  ASSERT_EQ(source.Open(), "");
  const test::CaptureCost cost = test::MeasureCapture(source, 100, 3);
  EXPECT_EQ(cost.problem, "");
  std::printf("1920x1080: %.3f ms of processor a frame, handed over in %.3f ms\n", cost.cpu_ms, cost.hand_over_ms);
  EXPECT_LE(cost.places, options.camera.buffers);  // nothing is copied
}

}  // namespace
}  // namespace chequer
