#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <optional>

#include "integration/workspace.h"
#include "support/deadline.h"
#include "support/process.h"
#include "support/service_manager.h"
#include "support/tcp_server.h"

namespace chequer {
namespace {

using std::chrono::seconds;
using test::ComesTrue;
using test::DemoRecording;
using test::HasPoses;
using test::LcmGreeting;
using test::Process;
using test::ServiceManager;
using test::Subscriber;
using test::TcpServer;
using test::Workspace;
using ::testing::HasSubstr;
using ::testing::Not;

/// systemd asks twice and kills after five seconds.
constexpr seconds kPrompt{4};

std::string MakePipe(const std::filesystem::path& path) {
  if (::mkfifo(path.c_str(), 0600) != 0) throw std::runtime_error("no pipe at " + path.string());
  return path.string();
}

void ChangeConfiguration(const std::string& file, const std::string& expression) {
  Process sed({"sed", "-i", expression, file});
  ASSERT_EQ(sed.Wait(), 0) << sed.output();
}

void ExpectPromptEnd(Process& daemon) {
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(kPrompt), 0) << daemon.output();
}

// systemctl start returns with READY.
TEST(DaemonBounds, IsReadyWhereEveryFrameIsOfAnotherSizeAndSaysSo) {
  const Workspace workspace;
  ServiceManager manager(workspace.path() / "notify");
  const std::string config = workspace.Configure("loop = true");
  std::ifstream camera(DemoRecording() / "camera.toml");
  std::string text(std::istreambuf_iterator<char>(camera), {});
  text.replace(text.find("width = 640"), 11, "width = 648");
  std::ofstream(workspace.path() / "other.toml") << text;
  ChangeConfiguration(config, "s|^calibration = .*|calibration = \"other.toml\"|");
  Process daemon({CHEQUERD, "--config", config}, {manager.variable()});
  EXPECT_THAT(manager.WaitFor("STATUS"), HasSubstr("delivers 640x480, its calibration is for 648x480"));
  EXPECT_EQ(manager.WaitFor("READY"), "READY=1");
  EXPECT_TRUE(daemon.WaitForOutput("its calibration is for 648x480")) << daemon.output();
  ExpectPromptEnd(daemon);
}

TEST(DaemonBounds, IsReadyWhereEveryFrameIsCorruptAndSaysSo) {
  const Workspace workspace;
  const std::filesystem::path copy = workspace.path() / "swarm";
  std::filesystem::copy(DemoRecording(), copy);
  for (const auto& entry : std::filesystem::directory_iterator(copy))
    if (entry.path().extension() == ".jpg" && entry.path().filename() != "000000.jpg")
      std::ofstream(entry.path()) << "no picture";
  ServiceManager manager(workspace.path() / "notify");
  // The first is whole, so that the recording can be opened, and does not come.
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true\nfaults = [\"truncate 0\"]", "", copy)},
                 {manager.variable()});
  EXPECT_THAT(manager.WaitFor("STATUS"), HasSubstr("frames are unusable"));
  EXPECT_EQ(manager.WaitFor("READY"), "READY=1");
  ExpectPromptEnd(daemon);
}

TEST(DaemonBounds, RefusesAPipeAsCalibrationWhenReloaded) {
  const Workspace workspace;
  Subscriber subscriber;
  const std::string config = workspace.Configure("loop = true");
  const std::string pipe = MakePipe(workspace.path() / "pipe.toml");
  Process daemon({CHEQUERD, "--config", config});
  ASSERT_TRUE(subscriber.ReceiveUntil(HasPoses(1))) << daemon.output();
  ChangeConfiguration(config, "s|^calibration = .*|calibration = \"" + pipe + "\"|");
  daemon.Signal(SIGHUP);
  EXPECT_TRUE(daemon.WaitForOutput("pipe.toml: is a pipe, not a file")) << daemon.output();
  const std::size_t before = subscriber.received().poses.size();
  EXPECT_TRUE(subscriber.ReceiveUntil(HasPoses(before + 5)));
  ExpectPromptEnd(daemon);
}

TEST(DaemonBounds, RefusesAPipeAsIndexOfARecording) {
  const Workspace workspace;
  const std::filesystem::path copy = workspace.path() / "swarm";
  std::filesystem::copy(DemoRecording(), copy);
  std::filesystem::remove(copy / "frames.csv");
  MakePipe(copy / "frames.csv");
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true", "", copy)});
  EXPECT_EQ(daemon.Wait(), 78) << daemon.output();
  EXPECT_THAT(daemon.output(), HasSubstr("frames.csv: is a pipe, not a file"));
}

TEST(DaemonBounds, DoesNotWaitForTheReaderOfALog) {
  const Workspace workspace;
  const std::string pipe = MakePipe(workspace.path() / "log");
  Process daemon(
      {CHEQUERD, "--config", workspace.Configure("loop = true", "[publish]\nurl = \"file://" + pipe + "?mode=w\"")});
  EXPECT_TRUE(daemon.WaitForOutput("pipe, not a file")) << daemon.output();
  ExpectPromptEnd(daemon);
}

/// Runs against a server, with a watchdog; expects to be fed, to hear what is wrong, and a prompt end.
void ExpectToLiveWith(TcpServer::Manner manner, const std::string& greeting, const std::string& complaint) {
  const Workspace workspace;
  const TcpServer server(manner, greeting);
  ServiceManager manager(workspace.path() / "notify");
  Process daemon(
      {CHEQUERD, "--config",
       workspace.Configure("loop = true\npace = \"unlimited\"", "[publish]\nurl = \"" + server.url() + "\"")},
      {manager.variable(), "WATCHDOG_USEC=2000000"});
  EXPECT_EQ(manager.WaitFor("READY"), "READY=1") << daemon.output();
  EXPECT_TRUE(daemon.WaitForOutput(complaint)) << daemon.output();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(manager.WaitFor("WATCHDOG"), "WATCHDOG=1");
  ExpectPromptEnd(daemon);
  EXPECT_THAT(daemon.output(), Not(HasSubstr("the watchdog is not fed")));
}

TEST(DaemonBounds, LivesWithATcpServerThatSaysNothing) {
  ExpectToLiveWith(TcpServer::Manner::kSilent, "", "accepts and says nothing");
}

TEST(DaemonBounds, LivesWithATcpServerThatStopsReading) {
  ExpectToLiveWith(TcpServer::Manner::kGreets, LcmGreeting(), "does not read");
}

/// Whether a process has a file open.
bool HasOpen(pid_t process, const std::filesystem::path& file) {
  std::error_code gone;
  std::filesystem::directory_iterator entry("/proc/" + std::to_string(process) + "/fd", gone);
  for (; !gone && entry != std::filesystem::directory_iterator(); entry.increment(gone))
    if (std::filesystem::read_symlink(entry->path(), gone) == file) return true;
  return false;
}

/// Sends a signal while the configuration is being read. @return the exit status.
std::optional<int> SignalEarly(int signal) {
  const Workspace workspace;
  // A table of kernels that takes a while to read, and is none.
  const std::filesystem::path table = workspace.path() / "table";
  std::ofstream(table) << "";
  std::filesystem::resize_file(table, 64'000'000);
  const std::string config = workspace.Configure("loop = true");
  ChangeConfiguration(config, "s|^variant = .*|variant = \"table\"\\ntable = \"table\"|");
  Process daemon({CHEQUERD, "--config", config});
  EXPECT_TRUE(ComesTrue([&] { return HasOpen(daemon.pid(), table) || !daemon.IsRunning(); }));
  daemon.Signal(signal);
  const std::optional<int> status = daemon.Wait();
  EXPECT_THAT(daemon.output(), HasSubstr("is not a kernel"));
  return status;
}

TEST(DaemonBounds, HoldsSignalsThatComeWhileItReadsItsConfiguration) {
  EXPECT_EQ(SignalEarly(SIGHUP), 78);
  EXPECT_EQ(SignalEarly(SIGTERM), 78);
}

TEST(DaemonBounds, HoldsSignalsThatComeBeforeItsLibrariesAreInitialised) {
  Process daemon({"env", "LD_PRELOAD=" EARLY_HANG_UP, CHEQUERD, "--config", "/no/such/file.toml"});
  EXPECT_EQ(daemon.Wait(), 78) << daemon.output();
}

TEST(DaemonBounds, SurvivesAReaderOfItsLogThatGoesAway) {
  const Workspace workspace;
  Subscriber subscriber;
  const std::string config = workspace.Configure("loop = true");
  Process daemon({"bash", "-c", "exec \"$0\" --config \"$1\" 2> >(exec true)", CHEQUERD, config});
  ASSERT_TRUE(subscriber.ReceiveUntil(HasPoses(1)));
  daemon.Signal(SIGHUP);  // is logged
  const std::size_t before = subscriber.received().poses.size();
  EXPECT_TRUE(subscriber.ReceiveUntil(HasPoses(before + 20)));
  ExpectPromptEnd(daemon);
}

TEST(DaemonBounds, IsStartedAgainWithoutAWaitWhereItWasStoppedOnPurpose) {
  const Workspace workspace;
  const std::string folder = "RUNTIME_DIRECTORY=" + workspace.path().string();
  const std::string config = workspace.Configure("loop = true");
  for (int i = 0; i < 5; ++i) {
    Process daemon({CHEQUERD, "--config", config}, {folder});
    ASSERT_TRUE(daemon.WaitForOutput("workers")) << daemon.output();
    ExpectPromptEnd(daemon);
    EXPECT_THAT(daemon.output(), Not(HasSubstr("waiting"))) << i;
  }
}

}  // namespace
}  // namespace chequer
