// What chequerd publishes on request, and what it hears.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <vector>

#include "integration/workspace.h"
#include "publish/ask_channel.h"
#include "publish/lcm_subscriber.h"
#include "publish/wire_view.h"
#include "support/deadline.h"
#include "support/process.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::Process;
using test::SetMulticastRoute;
using test::Workspace;
using Time = std::chrono::steady_clock;

/// Asks, and keeps what comes.
class Asker {
 public:
  Asker()
      : subscriber_(LcmSubscriber::OfBytes(DefaultListenUrl(), {"CHEQUER_test", "", true},
                                           [this](const std::string&, std::span<const std::uint8_t> bytes) {
                                             if (auto message = DecodeViewMessage(bytes))
                                               Take(*message);
                                             else
                                               ++others;
                                           })) {}

  /// Asks every 200 ms until the condition holds.
  bool Until(const AskMessage& ask, const std::function<bool()>& condition, milliseconds timeout = seconds(20)) {
    const auto end = Time::now() + timeout;
    auto next = Time::now();
    while (!condition() && Time::now() < end) {
      if (Time::now() >= next) {
        sender_.Send("CHEQUER_test", ask);
        next = Time::now() + milliseconds(200);
      }
      subscriber_.Wait(milliseconds(50));
    }
    return condition();
  }
  void Listen(milliseconds time) {
    const auto end = Time::now() + time;
    while (Time::now() < end) subscriber_.Wait(milliseconds(20));
  }

  std::vector<PreviewMessage> previews;
  std::vector<DetailMessage> details;
  std::vector<CameraMessage> cameras;
  int others = 0;

 private:
  void Take(const ViewMessage& message) {
    if (const auto* preview = std::get_if<PreviewMessage>(&message)) previews.push_back(*preview);
    if (const auto* detail = std::get_if<DetailMessage>(&message)) details.push_back(*detail);
    if (const auto* camera = std::get_if<CameraMessage>(&message)) cameras.push_back(*camera);
  }
  AskSender sender_{ParseLcmUrl(DefaultListenUrl(), LcmDirection::kSubscribe)};
  LcmSubscriber subscriber_;
};

AskMessage AskAll() {
  AskMessage ask{.asker = 3, .wants_camera = true, .preview = AskMessage::Preview{{}, 320}, .detail = MarkerChoice{}};
  ask.detail->id = 5;
  return ask;
}

/// Lines of the kernel's table of sockets that are bound to LCM's port.
int BoundSockets(pid_t daemon) {
  std::ifstream table("/proc/" + std::to_string(daemon) + "/net/udp");
  int bound = 0;
  for (std::string line; std::getline(table, line);) bound += line.find(":1DF3 ") != std::string::npos ? 1 : 0;
  return bound;
}

/// Time of a processor that a thread has taken.
double ThreadSeconds(pid_t process, const std::string& name) {
  for (const auto& task : std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task")) {
    std::string comm;
    std::ifstream(task.path() / "comm") >> comm;
    double nanoseconds = 0;
    std::ifstream(task.path() / "schedstat") >> nanoseconds;
    if (comm == name) return nanoseconds / 1e9;
  }
  return 0;
}

TEST(ViewRequests, AreAnsweredAndRunOut) {
  const Workspace workspace;
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true")});
  ASSERT_TRUE(daemon.WaitForOutput("workers"));
  Asker asker;
  ASSERT_TRUE(asker.Until(AskAll(), [&] {
    return asker.previews.size() > 2 && !asker.details.empty() && !asker.cameras.empty();
  })) << daemon.output();
  const PreviewMessage& preview = asker.previews.back();
  EXPECT_EQ(preview.camera, "test");
  EXPECT_EQ(preview.asker, 3);
  EXPECT_EQ(preview.width, 320);
  EXPECT_EQ(preview.height, 240);
  EXPECT_EQ(preview.image_width, 640);
  const DetailMessage& detail = asker.details.back();
  EXPECT_TRUE(detail.found) << detail.message;
  EXPECT_EQ(detail.id, 5u);
  EXPECT_EQ(detail.cells.size(), 36u);
  ASSERT_TRUE(asker.cameras[0].model);
  EXPECT_EQ(asker.cameras[0].model->fx, 480);
  ASSERT_EQ(asker.cameras[0].families.size(), 1u);
  EXPECT_EQ(asker.cameras[0].families[0].side_m, 0.12);
  asker.Listen(milliseconds(2500));  // the last request runs out
  asker.previews.clear();
  asker.others = 0;
  asker.Listen(milliseconds(1000));
  EXPECT_TRUE(asker.previews.empty()) << "nobody asks any more";
  EXPECT_GT(asker.others, 5) << "poses go on";
}

TEST(ViewRequests, AreHeardThroughOneSocket) {
  const Workspace workspace;
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true")});
  ASSERT_TRUE(daemon.WaitForOutput("workers"));
  EXPECT_TRUE(test::ComesTrue([&] { return BoundSockets(daemon.pid()) == 1; }));
  AskMessage zoom{
      .asker = 4, .wants_camera = false, .preview = AskMessage::Preview{{100, 100, 200, 100}, 640}, .detail = {}};
  Asker asker;
  ASSERT_TRUE(asker.Until(zoom, [&] { return !asker.previews.empty(); }));
  EXPECT_EQ(asker.previews[0].region, (PixelRegion{100, 100, 200, 100}));
  EXPECT_EQ(asker.previews[0].width, 200);
  EXPECT_TRUE(asker.details.empty() && asker.cameras.empty()) << "what was not asked for";
}

TEST(ViewRequests, AreNotHeardWhereTheyAreNotAllowed) {
  const Workspace workspace;
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true", "[view]\nallow = false")});
  ASSERT_TRUE(daemon.WaitForOutput("workers"));
  Asker asker;
  EXPECT_FALSE(asker.Until(
      AskAll(), [&] { return !asker.previews.empty() || !asker.details.empty() || !asker.cameras.empty(); },
      milliseconds(1500)));
  EXPECT_GT(asker.others, 5);
  EXPECT_EQ(BoundSockets(daemon.pid()), 1) << "the test's own";
}

TEST(ViewRequests, AreOffByDefaultWhereMessagesLeaveTheHost) {
  const Workspace workspace;
  Process daemon({CHEQUERD, "--config",
                  workspace.Configure("loop = true", "[publish]\nurl = \"udpm://239.255.76.68:7668?ttl=1\"")});
  ASSERT_TRUE(daemon.WaitForOutput("workers"));
  Asker asker;
  AskSender elsewhere(ParseLcmUrl("udpm://239.255.76.68:7668?ttl=1", LcmDirection::kSubscribe));
  EXPECT_FALSE(asker.Until(
      AskAll(),
      [&] {
        elsewhere.Send("CHEQUER_test", AskAll());
        return !asker.cameras.empty();
      },
      milliseconds(800)));
}

/// Whatever comes on the channel takes next to nothing and changes nothing.
TEST(ViewRequests, AFloodOfThemHoldsUpNoPose) {
  const Workspace workspace;
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true")});
  ASSERT_TRUE(daemon.WaitForOutput("workers"));
  Asker asker;
  AskSender flood(ParseLcmUrl(DefaultListenUrl(), LcmDirection::kSubscribe));
  AskMessage ask = AskAll();
  for (int i = 0; i < 20'000; ++i) {
    ask.asker = i;
    flood.Send("CHEQUER_test", ask);
  }
  asker.others = 0;
  const auto end = Time::now() + seconds(20);
  while (asker.others < 20 && Time::now() < end) asker.Listen(milliseconds(50));
  EXPECT_GE(asker.others, 20) << "frames go on";
  EXPECT_LT(ThreadSeconds(daemon.pid(), "chq-view"), 1.0) << "of 20000 requests it has read some hundred";
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0);
}

}  // namespace
}  // namespace chequer
