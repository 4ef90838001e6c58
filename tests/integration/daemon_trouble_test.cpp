#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>

#include "integration/workspace.h"
#include "support/process.h"

namespace chequer {
namespace {

using std::chrono::seconds;
using test::DemoRecording;
using test::Process;
using test::Received;
using test::SetMulticastRoute;
using test::Subscriber;
using test::Workspace;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

int Count(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

/// Runs the recording to its end as fast as it goes, with faults.
Received Replay(const std::string& faults, std::string* log = nullptr) {
  const Workspace workspace;
  Subscriber subscriber;
  Process daemon({CHEQUERD, "--config", workspace.Configure("pace = \"unlimited\"\nfaults = [" + faults + "]")});
  EXPECT_TRUE(subscriber.ReceiveUntil([](const Received& got) { return got.HasEnded(); })) << daemon.output();
  EXPECT_EQ(daemon.Wait(), 0) << daemon.output();
  if (log != nullptr) *log = daemon.output();
  return subscriber.received();
}

std::vector<std::uint64_t> Missing(const Received& got) {
  std::vector<std::uint64_t> missing;
  std::uint64_t next = 0;
  for (const PosesMessage& message : got.poses) {
    for (; next < message.sequence; ++next) missing.push_back(next);
    ++next;
  }
  return missing;
}

TEST(DaemonTrouble, GoesOnAfterAStall) {
  const Received got = Replay("\"stall 5 300ms\"");
  EXPECT_EQ(got.poses.size(), 60u);
  EXPECT_TRUE(Missing(got).empty());
}

TEST(DaemonTrouble, CountsFramesThatWereLostBefore) {
  const Received got = Replay("\"drop 10 3\"");
  EXPECT_THAT(Missing(got), ElementsAre(10, 11, 12));
  EXPECT_EQ(got.Dropped("lost_before"), 3u);
  EXPECT_EQ(got.poses.back().frames_dropped, 3u);
}

TEST(DaemonTrouble, CountsFramesThatAreCutOff) {
  std::string log;
  const Received got = Replay("\"truncate 7\", \"truncate 8\"", &log);
  EXPECT_THAT(Missing(got), ElementsAre(7, 8));
  EXPECT_EQ(got.Dropped("corrupt"), 2u);
  EXPECT_EQ(got.Dropped("lost_before"), 0u);
  EXPECT_EQ(Count(log, "a frame is unusable"), 1) << log;
}

TEST(DaemonTrouble, SurvivesPixelsThatAreNoise) {
  const Received got = Replay("\"corrupt 4\", \"corrupt 5\"");
  ASSERT_EQ(got.poses.size(), 60u);
  for (const std::size_t frame : {4u, 5u})
    for (const MarkerPose& marker : got.poses[frame].markers)
      if (marker.id) {
        EXPECT_LT(*marker.id, 8u);  // the recording's ids: noise is no marker
      }
}

TEST(DaemonTrouble, OpensACameraAgainThatVanished) {
  std::string log;
  const Received got = Replay("\"vanish 20 2 opens\", \"vanish 40 200ms\"", &log);
  EXPECT_EQ(got.poses.size(), 60u);
  EXPECT_TRUE(Missing(got).empty());
  EXPECT_EQ(Count(log, "the camera was lost"), 2) << log;
  EXPECT_EQ(Count(log, "frames come from"), 2) << log;
}

TEST(DaemonTrouble, CountsFramesWhoseFilesAreMissingOrCutOff) {
  const Workspace workspace;
  const std::filesystem::path copy = workspace.path() / "swarm";
  std::filesystem::copy(DemoRecording(), copy);
  std::filesystem::remove(copy / "000010.jpg");
  std::filesystem::resize_file(copy / "000020.jpg", 3000);
  Subscriber subscriber;
  Process daemon({CHEQUERD, "--config", workspace.Configure("pace = \"unlimited\"", "", copy)});
  ASSERT_TRUE(subscriber.ReceiveUntil([](const Received& got) { return got.HasEnded(); })) << daemon.output();
  EXPECT_EQ(daemon.Wait(), 0);
  EXPECT_THAT(Missing(subscriber.received()), ElementsAre(10, 20));
  EXPECT_EQ(subscriber.received().Dropped("corrupt"), 2u);
  EXPECT_THAT(daemon.output(), HasSubstr("000010.jpg"));
}

TEST(DaemonTrouble, DropsFramesThatItsCalibrationIsNotFor) {
  const Workspace workspace;
  const std::string config = workspace.Configure("pace = \"unlimited\"");
  Process copy({"sh", "-c",
                "sed 's/^width = .*/width = 1280/' '" + (DemoRecording() / "camera.toml").string() + "' > '" +
                    (workspace.path() / "other.toml").string() +
                    "' && sed -i 's|^calibration = .*|calibration = " + "\"other.toml\"|' '" + config + "'"});
  ASSERT_EQ(copy.Wait(), 0) << copy.output();
  Subscriber subscriber;
  Process daemon({CHEQUERD, "--config", config});
  ASSERT_TRUE(subscriber.ReceiveUntil([](const Received& got) { return got.HasEnded(); })) << daemon.output();
  EXPECT_TRUE(subscriber.received().poses.empty());
  EXPECT_EQ(subscriber.received().Dropped("wrong_size"), 60u);
  EXPECT_EQ(daemon.Wait(), 0);
  EXPECT_EQ(Count(daemon.output(), "delivers 640x480, its calibration is for 1280x480"), 1) << daemon.output();
}

TEST(DaemonTrouble, WaitsForAMulticastRouteWithOneMessage) {
  const Workspace workspace;
  SetMulticastRoute(false);
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true")});
  ASSERT_TRUE(daemon.WaitForOutput("ip route add 224.0.0.0/4 dev lo")) << daemon.output();
  EXPECT_THAT(daemon.output(), HasSubstr("udpm://239.255.76.67:7667?ttl=0"));
  SetMulticastRoute(true);
  Subscriber subscriber;
  ASSERT_TRUE(subscriber.ReceiveUntil([](const Received& got) { return !got.poses.empty(); })) << daemon.output();
  ASSERT_TRUE(daemon.WaitForOutput("works again"));
  EXPECT_TRUE(daemon.IsRunning());
  EXPECT_EQ(Count(daemon.output(), "224.0.0.0/4"), 1) << daemon.output();
  EXPECT_EQ(Count(daemon.output(), "Network is unreachable"), 1) << daemon.output();
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0);
}

TEST(DaemonTrouble, SurvivesTheLossOfTheRouteAndTellsOfIt) {
  const Workspace workspace;
  Subscriber subscriber;
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true")});
  ASSERT_TRUE(subscriber.ReceiveUntil([](const Received& got) { return !got.poses.empty(); })) << daemon.output();
  SetMulticastRoute(false);
  ASSERT_TRUE(daemon.WaitForOutput("did not take a message")) << daemon.output();
  SetMulticastRoute(true);
  ASSERT_TRUE(daemon.WaitForOutput("works again")) << daemon.output();
  const std::size_t before = subscriber.received().statuses.size();
  ASSERT_TRUE(subscriber.ReceiveUntil([&](const Received& got) { return got.statuses.size() > before + 1; }));
  EXPECT_GT(subscriber.received().statuses.back().publisher.failed, 0u);
  EXPECT_EQ(subscriber.received().statuses.back().publisher.state, PublisherState::kReady);
}

}  // namespace
}  // namespace chequer
