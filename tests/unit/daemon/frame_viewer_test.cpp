#include "daemon/frame_viewer.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "publish/ask_channel.h"
#include "support/deadline.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using test::ComesTrue;

/// A prefix that no other test uses, nor another run of this one on the same host.
std::string ViewedPrefix() { return "VIEWED_" + std::to_string(getpid()); }
const std::string kViewedUrl = "udpm://239.255.76.99:7669?ttl=0";

class CountedLease final : public FrameLease {
 public:
  explicit CountedLease(std::atomic<int>& leases) : leases_(leases) { ++leases_; }
  ~CountedLease() override { --leases_; }

 private:
  std::atomic<int>& leases_;
};

/// A viewer on a thread of its own, and who asks it over the loopback interface.
class FrameViewerTest : public ::testing::Test {
 protected:
  void TearDown() override {
    viewer_.Close();
    thread_.join();
    EXPECT_EQ(leases_, 0) << "every buffer was given back";
  }

  void Ask(bool detail = false) {
    AskMessage ask{.asker = 1, .wants_camera = true, .preview = AskMessage::Preview{}, .detail = {}};
    if (detail) ask.detail = MarkerChoice{0, 7, {10, 10}};
    ASSERT_TRUE(sender_.Send(ViewedPrefix(), ask));
  }
  bool Wants() { return viewer_.WantsFrame(Clock::System().monotonic()); }
  ViewedFrame Viewed() {
    ViewedFrame viewed;
    viewed.frame.image = image_.view();
    viewed.frame.lease = std::make_unique<CountedLease>(leases_);
    return viewed;
  }

  std::atomic<int> leases_{0};
  Image image_{PixelFormat::kBgr8, 64, 48};
  FrameViewer viewer_{{kViewedUrl, ViewedPrefix(), {}, {}}, Clock::System()};
  AskSender sender_{ParseLcmUrl(kViewedUrl, LcmDirection::kSubscribe)};
  std::thread thread_{[this] { viewer_.Run(); }};
};

TEST_F(FrameViewerTest, WantsAFrameWhenSomebodyLooks) {
  EXPECT_FALSE(Wants());
  ASSERT_TRUE(ComesTrue([&] {
    Ask();
    return Wants();
  }));
  viewer_.Offer(Viewed());
  EXPECT_TRUE(ComesTrue([&] { return leases_ == 0; })) << "its buffer is given back when it was shown";
  EXPECT_TRUE(ComesTrue([&] {
    Ask();
    return Wants();
  })) << "the next one is wanted";
}

TEST_F(FrameViewerTest, ChoosesTheMarkerThatIsAskedFor) {
  std::vector<MarkerPose> markers(2);
  markers[0].id = 3;
  markers[1].id = 7;
  EXPECT_FALSE(viewer_.Choose(markers));
  ASSERT_TRUE(ComesTrue([&] {
    Ask(true);
    return viewer_.Choose(markers).has_value();
  }));
  EXPECT_EQ(viewer_.Choose(markers)->id, 7u);
}

TEST_F(FrameViewerTest, ANewerFrameTakesThePlaceOfOneThatWaits) {
  for (int i = 0; i < 100; ++i) viewer_.Offer(Viewed());
  EXPECT_LE(leases_, 2) << "one waits, one may be at work";
}

TEST_F(FrameViewerTest, TakesNoFrameOnceItIsClosed) {
  viewer_.Close();
  viewer_.Offer(Viewed());
  EXPECT_EQ(leases_, 0);
  EXPECT_FALSE(Wants());
}

}  // namespace
}  // namespace chequer
