// How a calibration is shown: on request alone, and no more often than is of use.
#include "publish/calibration_channel.h"

#include <gtest/gtest.h>

#include <chrono>

#include "publish/ask_channel.h"
#include "publish/lcm_subscriber.h"
#include "publish/wire_view.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A calibration whose clock the test drives, and one who looks.
struct Looking {
  MonotonicTime now{seconds(100)};
  LcmUrl url = ParseLcmUrl(kDefaultLcmUrl, LcmDirection::kPublish);
  CalibrationChannel channel{
      url, "CHEQUER_test", {.utc = [] { return UtcTime(); }, .monotonic = [this] { return now; }}};
  AskSender sender{url};

  void Ask(bool for_calibrations, const std::string& prefix = "CHEQUER") {
    sender.Send(prefix, {.asker = 7, .preview = {}, .detail = {}, .wants_calibration = for_calibrations});
  }
  bool IsAskedSoon() {
    for (const auto end = std::chrono::steady_clock::now() + seconds(5); std::chrono::steady_clock::now() < end;)
      if (channel.IsAsked()) return true;
    return false;
  }
};

TEST(CalibrationChannel, SendsToWhoAsksUntilThatRunsOut) {
  Looking looking;
  std::vector<CalibrationMessage> got;
  LcmSubscriber subscriber =
      LcmSubscriber::OfBytes(DefaultListenUrl(), {"CHEQUER_test", "", true},
                             [&](const std::string& name, std::span<const std::uint8_t> bytes) {
                               EXPECT_EQ(name, "CHEQUER_test_SETUP");
                               got.push_back(std::get<CalibrationMessage>(DecodeViewMessage(bytes).value()));
                             });
  EXPECT_FALSE(looking.channel.IsDue()) << "nobody looks";
  looking.Ask(true);
  ASSERT_TRUE(looking.IsAskedSoon());
  EXPECT_TRUE(looking.channel.IsDue());
  CalibrationMessage message;
  message.advice = "tilt it";
  looking.channel.Send(message);
  EXPECT_EQ(subscriber.Wait(seconds(5)), LcmSubscriber::Outcome::kMessage);
  ASSERT_EQ(got.size(), 1u);
  EXPECT_EQ(got[0].advice, "tilt it");
  EXPECT_FALSE(looking.channel.IsDue()) << "one was just sent";
  EXPECT_TRUE(looking.channel.IsAsked());
  looking.now += CalibrationChannel::kPeriod;
  EXPECT_TRUE(looking.channel.IsDue());
  looking.now += CalibrationChannel::kAskLasts;
  EXPECT_FALSE(looking.channel.IsAsked());
}

TEST(CalibrationChannel, PassesOverWhatIsAskedOfCameras) {
  Looking looking;
  looking.Ask(true, "CHEQUER_test");
  looking.Ask(false);
  AskListener other(looking.url, "CHEQUER");
  looking.Ask(false);
  // Both hear on the same channel, in the same order: what this one has heard, that one has.
  for (const auto end = std::chrono::steady_clock::now() + seconds(5); !other.Next();)
    ASSERT_LT(std::chrono::steady_clock::now(), end);
  EXPECT_FALSE(looking.channel.IsAsked());
}

}  // namespace
}  // namespace chequer
