#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>

#include "integration/workspace.h"
#include "support/process.h"
#include "support/service_manager.h"
#include "tools/truth_check.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using test::DemoRecording;
using test::HasPoses;
using test::Process;
using test::Received;
using test::ServiceManager;
using test::Subscriber;
using test::Workspace;
using ::testing::HasSubstr;

bool Ended(const Received& got) { return got.HasEnded(); }

TEST(Daemon, PublishesEveryFrameInOrderWithThePosesOfTheTruth) {
  const Workspace workspace;
  Subscriber subscriber;
  Process daemon({CHEQUERD, "--config", workspace.Configure("pace = \"unlimited\"", "[pipeline]\nworkers = 4")});
  ASSERT_TRUE(subscriber.ReceiveUntil(Ended)) << daemon.output();
  EXPECT_EQ(daemon.Wait(), 0) << daemon.output();
  const Received& got = subscriber.received();
  ASSERT_EQ(got.poses.size(), 60u);
  TruthCheck truth(DemoRecording());
  for (std::size_t i = 0; i < got.poses.size(); ++i) {
    EXPECT_EQ(got.poses[i].sequence, i);
    EXPECT_EQ(got.poses[i].frames_dropped, 0u);
    EXPECT_EQ(got.poses[i].camera, "test");
    EXPECT_EQ(got.poses[i].frame, "camera");
    EXPECT_GE(got.poses[i].published_monotonic, got.poses[i].captured_monotonic);
    truth.Add(got.poses[i]);
  }
  EXPECT_TRUE(truth.Passed()) << truth.Summary();
  EXPECT_EQ(got.statuses.back().frames_published, 60u);
  EXPECT_EQ(got.statuses.back().workers, 4);
}

TEST(Daemon, KeepsPaceAndTellsItsLatency) {
  const Workspace workspace;
  Subscriber subscriber;
  Process daemon({CHEQUERD, "--config", workspace.Configure("pace = \"recorded\"")});
  ASSERT_TRUE(subscriber.ReceiveUntil(Ended)) << daemon.output();
  const Received& got = subscriber.received();
  EXPECT_EQ(got.poses.size() + got.statuses.back().frames_dropped, 60u);
  EXPECT_GE(got.statuses.size(), 3u);  // 3 s
  const StageLatency& total = got.statuses.front().stages.back();
  EXPECT_EQ(total.stage, "total");
  EXPECT_GT(total.frames, 0u);
  EXPECT_GT(total.median, milliseconds(0));
  EXPECT_LE(total.median, total.p99);
  EXPECT_LE(total.p99, total.worst);
}

/// SIGTERM must end it within half a second, with status 0.
void ExpectQuickStop(Process& daemon, int signal) {
  const auto begin = std::chrono::steady_clock::now();
  daemon.Signal(signal);
  const auto status = daemon.Wait();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, milliseconds(500));
  EXPECT_EQ(status, 0) << daemon.output();
}

TEST(Daemon, StopsAtOnceWhileFramesCome) {
  const Workspace workspace;
  for (const int signal : {SIGTERM, SIGINT}) {
    Subscriber subscriber;
    Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true\npace = \"unlimited\"")});
    ASSERT_TRUE(subscriber.ReceiveUntil(HasPoses(10))) << daemon.output();
    ExpectQuickStop(daemon, signal);
    // What was published is whole: the last status counts just what arrived.
    EXPECT_TRUE(subscriber.ReceiveUntil([](const Received& got) {
      return !got.statuses.empty() && got.statuses.back().frames_published == got.poses.size();
    }));
  }
}

TEST(Daemon, StopsAtOnceWhileItWaitsForTheCamera) {
  const Workspace workspace;
  Process daemon({CHEQUERD, "--config", workspace.Configure("faults = [\"vanish 0 1000000 opens\"]")});
  ASSERT_TRUE(daemon.WaitForOutput("cannot be opened")) << daemon.output();
  ExpectQuickStop(daemon, SIGTERM);
}

// With this pace the camera waits for workers that are busy: three frames are three, however slow the machine.
TEST(Daemon, StopsAtOnceWhileTheCameraIsSilent) {
  const Workspace workspace;
  Subscriber subscriber;
  Process daemon({CHEQUERD, "--config", workspace.Configure("pace = \"unlimited\"\nfaults = [\"stall 3 1000s\"]")});
  ASSERT_TRUE(subscriber.ReceiveUntil([](const Received& got) { return got.poses.size() == 3; })) << daemon.output();
  ExpectQuickStop(daemon, SIGTERM);
}

TEST(Daemon, RefusesABadConfigurationWithStatus78) {
  const Workspace workspace;
  Process unknown_key({CHEQUERD, "--config", workspace.Configure("speed = 3")});
  EXPECT_EQ(unknown_key.Wait(), 78);
  EXPECT_THAT(unknown_key.output(), HasSubstr("capture.speed"));
  Process bad_url({CHEQUERD, "--config", workspace.Configure("", "[publish]\nurl = \"udpm://nowhere\"")});
  EXPECT_EQ(bad_url.Wait(), 78);
  EXPECT_THAT(bad_url.output(), HasSubstr("udpm://nowhere"));
  Process no_file({CHEQUERD, "--config", (workspace.path() / "none.toml").string()});
  EXPECT_EQ(no_file.Wait(), 78);
  EXPECT_THAT(no_file.output(), HasSubstr("none.toml"));
  Process no_recording({CHEQUERD, "--config", workspace.Configure("", "", "/nowhere")});
  EXPECT_EQ(no_recording.Wait(), 78);
  EXPECT_THAT(no_recording.output(), HasSubstr("/nowhere"));
  Process no_option({CHEQUERD});
  EXPECT_EQ(no_option.Wait(), 2);
  EXPECT_THAT(no_option.output(), HasSubstr("--config"));
}

TEST(Daemon, TellsTheServiceManager) {
  const Workspace workspace;
  ServiceManager manager(workspace.path() / "notify");
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true")},
                 {manager.variable(), "WATCHDOG_USEC=10000000"});
  EXPECT_EQ(manager.WaitFor("READY"), "READY=1");
  EXPECT_THAT(manager.WaitFor("STATUS"), HasSubstr("8.0 markers a frame"));
  EXPECT_EQ(manager.WaitFor("WATCHDOG"), "WATCHDOG=1");
  daemon.Signal(SIGTERM);
  EXPECT_EQ(manager.WaitFor("STOPPING"), "STOPPING=1");
  EXPECT_EQ(daemon.Wait(), 0);
}

TEST(Daemon, IsReadyWhileItWaitsForTheCamera) {
  const Workspace workspace;
  ServiceManager manager(workspace.path() / "notify");
  Process daemon({CHEQUERD, "--config", workspace.Configure("faults = [\"vanish 0 1000000 opens\"]")},
                 {manager.variable()});
  EXPECT_EQ(manager.WaitFor("READY"), "READY=1");
  EXPECT_THAT(manager.WaitFor("STATUS"), HasSubstr("waiting for the camera"));
}

}  // namespace
}  // namespace chequer
