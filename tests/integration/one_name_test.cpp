// Two senders of one camera's name, and what a daemon says of files and networks that are not its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <lcm/lcm-cpp.hpp>

#include "integration/workspace.h"
#include "publish/wire.h"
#include "support/process.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::Process;
using test::Workspace;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// As `cp example.toml north.toml` for two cameras of which one was given a name in its file.
TEST(OneName, BothDaemonsSayItAndStatusEndsWithThree) {
  const Workspace workspace;
  const std::string config = workspace.Configure("loop = true");
  Process one({CHEQUERD, "--config", config});
  ASSERT_TRUE(one.WaitForOutput("workers")) << one.output();
  Process well({CHEQUER, "status", "--seconds", "2.5"});
  EXPECT_EQ(well.Wait(), 0) << well.output();
  Process other({CHEQUERD, "--config", config});
  for (Process* daemon : {&one, &other})
    EXPECT_TRUE(daemon->WaitForOutput("another program publishes as CHEQUER_test too")) << daemon->output();
  Process unwell({CHEQUER, "status", "--seconds", "2.5"});
  EXPECT_EQ(unwell.Wait(), 3) << unwell.output();
  EXPECT_THAT(unwell.output(), HasSubstr("test: 2 programs publish as CHEQUER_test_STATUS"));
  Process by_name({CHEQUER, "status", "test", "--seconds", "20"});
  EXPECT_EQ(by_name.Wait(), 3) << "also where it listens no longer than to one status";
  EXPECT_THAT(by_name.output(), HasSubstr("another program publishes as CHEQUER_test too"));
  other.Signal(SIGTERM);
  EXPECT_EQ(other.Wait(), 0);
  EXPECT_TRUE(one.WaitForOutput("nobody else publishes on CHEQUER_test_STATUS any more")) << one.output();
}

/// A daemon of another host is heard by its status alone, where messages leave the host; here it sends over the loopback.
TEST(OneName, ASenderElsewhereIsHeard) {
  const Workspace workspace;
  Process daemon({CHEQUERD, "--config",
                  workspace.Configure("loop = true", "[publish]\nurl = \"udpm://239.255.76.67:7667?ttl=1\"")});
  ASSERT_TRUE(daemon.WaitForOutput("workers")) << daemon.output();
  lcm::LCM elsewhere;
  StatusMessage status;
  status.camera = "test";
  status.detections = {{"instance", 5}};
  WireEncoder encoder;
  const auto bytes = encoder.Encode(status);
  const auto deadline = std::chrono::steady_clock::now() + seconds(20);
  bool said = false;
  while (!said && std::chrono::steady_clock::now() < deadline) {
    elsewhere.publish("CHEQUER_test_STATUS", bytes.data(), static_cast<unsigned>(bytes.size()));
    said = daemon.WaitForOutput("another program publishes as CHEQUER_test too, on this host", milliseconds(300));
  }
  EXPECT_TRUE(said) << daemon.output();
}

TEST(OneName, OneFileAfterTheOtherGivesTheCamerasTheirNames) {
  const Workspace workspace;
  for (const char* name : {"north", "south"}) {
    const std::string config = (workspace.path() / (std::string(name) + ".toml")).string();
    std::ofstream(config) << "[capture]\npath = \"" << test::DemoRecording().string()
                          << "\"\n[[marker]]\nsize = \"6x6\"\nvariant = \"secded\"\n";
    Process daemon({CHEQUERD, "--config", config});
    EXPECT_TRUE(daemon.WaitForOutput(std::string("as CHEQUER_") + name + "_POSES")) << daemon.output();
  }
}

TEST(Check, WarnsOfMessagesThatLeaveTheHost) {
  const Workspace workspace;
  Process check({CHEQUERD, "--check", "--config",
                 workspace.Configure("", "[publish]\nurl = \"udpm://239.255.76.67:7667?ttl=1\"")});
  EXPECT_EQ(check.Wait(), 0);
  EXPECT_THAT(check.output(), AllOf(HasSubstr("warning"), HasSubstr("publish.url"), HasSubstr("forge")));
}

TEST(Reload, ARosterThatWasEditedIsSaidToHaveChanged) {
  const Workspace workspace;
  const auto write = [&](const std::string& name) {
    std::ofstream(workspace.path() / "robots.toml") << "[[robot]]\nname = \"" << name << "\"\nid = 1\nheight = 0.1\n";
  };
  write("alice");
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true", "[robots]\nfile = \"robots.toml\"")});
  ASSERT_TRUE(daemon.WaitForOutput("workers")) << daemon.output();
  daemon.Signal(SIGHUP);
  EXPECT_TRUE(daemon.WaitForOutput("again; nothing changed")) << daemon.output();
  write("bob");
  daemon.Signal(SIGHUP);
  EXPECT_TRUE(daemon.WaitForOutput("again; robots changed")) << daemon.output();
}

}  // namespace
}  // namespace chequer
