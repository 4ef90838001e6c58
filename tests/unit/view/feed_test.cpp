#include "view/feed.h"

#include <gtest/gtest.h>

#include "publish/wire.h"
#include "unit/publish/messages.h"
#include "unit/view/page.h"
#include "view/page_message.h"
#include "view/view_client.h"

namespace chequer {
namespace {

using test::At;
using test::JsonOf;
using test::KindOf;
using test::SamplePoses;
using test::SampleStatus;

constexpr std::int64_t kAsker = 500;

template <typename Message>
void Give(Feed& feed, const std::string& channel, const Message& message) {
  WireEncoder encoder;
  feed.Take(channel, encoder.Encode(message));
}

PreviewMessage Picture(std::uint64_t sequence, PixelRegion region = {0, 0, 1920, 1080}) {
  return {.captured_utc = {},
          .sequence = sequence,
          .camera = "a",
          .asker = kAsker,
          .image_width = 1920,
          .image_height = 1080,
          .region = region,
          .width = 64,
          .height = 36,
          .jpeg = {1}};
}

PageWish WishFor(std::initializer_list<TopicKind> kinds) {
  PageWish wish;
  wish.visible = true;
  for (const TopicKind kind : kinds) wish.kinds |= 1u << static_cast<unsigned>(kind);
  return wish;
}

TEST(Feed, ShowsACalibrationOfACameraThatNobodyKnewBefore) {
  Feed feed(kAsker);
  feed.set_watched(true);
  CalibrationMessage message;
  message.advice = "hold it into the top";
  message.rows = message.cols = 1;
  message.parts = {3};
  message.residuals = {{{1, 2}, {3, 4}}};
  feed.Take("CHEQUER_a_SETUP", EncodeView(message));
  ASSERT_EQ(feed.cameras(), 1u);
  EXPECT_EQ(feed.prefix(0), "CHEQUER_a");
  ViewClient client(nullptr);
  client.set_wish(WishFor({TopicKind::kCalibration}));
  const auto json = JsonOf(client.Take(feed, {}));
  EXPECT_EQ(json["advice"], "hold it into the top");
  EXPECT_EQ(json["parts"], nlohmann::json({3}));
  EXPECT_EQ(json["residuals"], nlohmann::json({1, 2, 3, 4}));
  EXPECT_FALSE(client.HasNews(feed, {}));
}

TEST(Feed, KnowsCamerasByTheirChannels) {
  Feed feed(kAsker);
  feed.set_watched(true);
  Give(feed, "CHEQUER_a_POSES", SamplePoses(1));
  Give(feed, "other_STATUS", SampleStatus());
  ASSERT_EQ(feed.cameras(), 2u);
  EXPECT_EQ(feed.prefix(1), "other");
  EXPECT_EQ(feed.CameraList()[0].name, "a");
  EXPECT_EQ(feed.CameraList()[1].name, "ceiling") << "as the status says";
  Give(feed, "no such channel_POSES", SamplePoses(1));
  Give(feed, "_POSES", SamplePoses(1));
  Give(feed, "CHEQUER_a_ELSE", SamplePoses(1));
  EXPECT_EQ(feed.cameras(), 2u);
  for (int i = 0; i < 100; ++i) Give(feed, "c" + std::to_string(i) + "_POSES", SamplePoses(0));
  EXPECT_EQ(feed.cameras(), Feed::kMostCameras) << "however many there are";
}

TEST(Feed, TakesStatusesAloneWhileNobodyLooks) {
  Feed feed(kAsker);
  Give(feed, "a_POSES", SamplePoses(1));
  EXPECT_EQ(feed.cameras(), 0u);
  Give(feed, "a_STATUS", SampleStatus());
  ASSERT_EQ(feed.cameras(), 1u);
  Give(feed, "a_POSES", SamplePoses(1));
  EXPECT_EQ(feed.topic(0, TopicKind::kFrame).version, 0u);
}

TEST(Feed, APictureHasTheMarkersOfItsOwnFrame) {
  Feed feed(kAsker);
  feed.set_watched(true);
  for (std::uint64_t sequence = 10; sequence < 20; ++sequence) {
    PosesMessage poses = SamplePoses(sequence - 9);
    poses.sequence = sequence;
    Give(feed, "a_POSES", poses);
  }
  feed.Take("a_PREVIEW", EncodeView(Picture(13)));
  const SharedPacket picture = feed.PacketOf(0, TopicKind::kPicture);
  ASSERT_TRUE(picture);
  EXPECT_EQ(At<double>(picture, 64 + 8), 13);
  EXPECT_EQ(At<std::uint32_t>(picture, 64 + 4), 4u) << "markers";
  feed.Take("a_PREVIEW", EncodeView(Picture(5)));
  EXPECT_EQ(At<std::uint32_t>(feed.PacketOf(0, TopicKind::kPicture), 4), 0u) << "it is too old";
}

TEST(Feed, APictureThatComesBeforeItsMarkersWaitsForThem) {
  Feed feed(kAsker);
  feed.set_watched(true);
  PosesMessage poses = SamplePoses(2);
  poses.sequence = 7;
  Give(feed, "a_POSES", poses);
  feed.Take("a_PREVIEW", EncodeView(Picture(8)));
  EXPECT_FALSE(feed.PacketOf(0, TopicKind::kPicture));
  poses.sequence = 8;
  Give(feed, "a_POSES", poses);
  ASSERT_TRUE(feed.PacketOf(0, TopicKind::kPicture));
  EXPECT_EQ(At<double>(feed.PacketOf(0, TopicKind::kPicture), 64 + 8), 8);
}

TEST(Feed, FramesOfADaemonBeforeAreNotThoseOfTheNext) {
  Feed feed(kAsker);
  feed.set_watched(true);
  PosesMessage poses = SamplePoses(3);
  for (poses.sequence = 1; poses.sequence < 9; ++poses.sequence) Give(feed, "a_POSES", poses);
  poses.sequence = 1;
  Give(feed, "a_POSES", poses);
  feed.Take("a_PREVIEW", EncodeView(Picture(5)));
  EXPECT_FALSE(feed.PacketOf(0, TopicKind::kPicture)) << "it waits for the new daemon's fifth frame";
}

TEST(Feed, PartsOfAFrameAreThoseThatWereAskedForHere) {
  Feed feed(kAsker);
  feed.set_watched(true);
  PreviewMessage part = Picture(1, {100, 100, 200, 100});
  feed.Take("a_PREVIEW", EncodeView(part));
  EXPECT_EQ(feed.topic(0, TopicKind::kZoom).version, 0u) << "another program asked for it";
  part.asker = kAsker + 1;
  feed.Take("a_PREVIEW", EncodeView(part));
  EXPECT_GT(feed.topic(0, TopicKind::kZoom).version, 0u);
  EXPECT_EQ(feed.topic(0, TopicKind::kPicture).version, 0u);
}

TEST(Feed, KeepsAHistoryOfTenMinutes) {
  Feed feed(kAsker);
  StatusMessage status = SampleStatus();
  for (int i = 0; i < 700; ++i) {
    status.frames_dropped = static_cast<std::uint64_t>(3 * i);
    Give(feed, "a_STATUS", status);
  }
  const auto rows = JsonOf(feed.PacketOf(0, TopicKind::kHistory))["rows"];
  EXPECT_EQ(rows.size(), 600u);
  EXPECT_EQ(rows[599][6], 3) << "lost since the one before";
}

TEST(Feed, PassesOverWhatIsDamaged) {
  Feed feed(kAsker);
  feed.set_watched(true);
  const std::vector<std::uint8_t> rubbish(100, 0xab);
  feed.Take("a_POSES", rubbish);
  std::vector<std::uint8_t> cut = EncodeView(Picture(1));
  cut.resize(cut.size() - 1);
  feed.Take("a_PREVIEW", cut);
  EXPECT_EQ(feed.unreadable(), 2u);
  EXPECT_EQ(feed.cameras(), 0u);
}

TEST(ViewClient, GetsTheNewestOfEachAndNothingTwice) {
  Feed feed(kAsker);
  feed.set_watched(true);
  ViewClient client(nullptr);
  client.set_wish(WishFor({TopicKind::kFrame, TopicKind::kStatus}));
  PosesMessage poses = SamplePoses(1);
  for (poses.sequence = 1; poses.sequence <= 50; ++poses.sequence) Give(feed, "a_POSES", poses);
  Give(feed, "b_POSES", SamplePoses(0));
  Give(feed, "a_STATUS", SampleStatus());
  const Topic none;
  std::vector<std::pair<TopicKind, int>> got;
  while (client.HasNews(feed, none)) {
    const SharedPacket packet = client.Take(feed, none);
    ASSERT_TRUE(packet);
    got.emplace_back(KindOf(packet), At<std::uint16_t>(packet, 2));
    if (KindOf(packet) == TopicKind::kFrame && got.back().second == 0) {
      EXPECT_EQ(At<double>(packet, 8), 50) << "49 were skipped";
    }
  }
  EXPECT_EQ(got.size(), 3u);
  EXPECT_FALSE(client.Take(feed, none));
}

TEST(ViewClient, AHiddenPageGetsNothing) {
  Feed feed(kAsker);
  feed.set_watched(true);
  Give(feed, "a_POSES", SamplePoses(1));
  Give(feed, "a_STATUS", SampleStatus());
  ViewClient client(nullptr);
  PageWish wish = WishFor({TopicKind::kFrame, TopicKind::kStatus});
  wish.visible = false;
  client.set_wish(wish);
  EXPECT_FALSE(client.HasNews(feed, {}));
  wish.visible = true;
  client.set_wish(wish);
  EXPECT_TRUE(client.HasNews(feed, {}));
}

TEST(ViewClient, GetsWhatItLooksAtAlone) {
  Feed feed(kAsker);
  feed.set_watched(true);
  Give(feed, "a_POSES", SamplePoses(1));
  Give(feed, "b_POSES", SamplePoses(1));
  ViewClient client(nullptr);
  PageWish wish = WishFor({TopicKind::kFrame});
  wish.camera = 1;
  client.set_wish(wish);
  const SharedPacket packet = client.Take(feed, {});
  ASSERT_TRUE(packet);
  EXPECT_EQ(At<std::uint16_t>(packet, 2), 1);
  EXPECT_FALSE(client.HasNews(feed, {}));
}

}  // namespace
}  // namespace chequer
