#include "view/client_message.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "view/request_sender.h"
#include "view/view_client.h"

namespace chequer {
namespace {

std::vector<std::uint8_t> Wish() {
  std::vector<std::uint8_t> bytes(48);
  bytes[0] = 1;
  bytes[1] = 1;
  const auto put = [&](std::size_t at, auto value) { std::memcpy(bytes.data() + at, &value, sizeof value); };
  put(4, std::uint32_t{0b110000});
  put(8, std::uint16_t{2});
  put(10, std::uint16_t{640});
  put(12, 10.0F);
  put(16, 20.0F);
  put(20, 300.0F);
  put(24, 200.0F);
  bytes[28] = 1;
  put(30, std::uint16_t{3});
  put(32, std::uint32_t{7});
  put(36, std::uint32_t{1});
  put(40, 50.5F);
  put(44, 60.5F);
  return bytes;
}

template <typename Value>
std::vector<std::uint8_t> With(std::vector<std::uint8_t> bytes, std::size_t at, Value value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
  return bytes;
}

TEST(ClientMessage, SaysWhatAPageLooksAt) {
  const auto message = ParseClientMessage(Wish());
  ASSERT_TRUE(message);
  const PageWish wish = std::get<PageWish>(*message);
  EXPECT_TRUE(wish.visible);
  EXPECT_TRUE(wish.Wants(TopicKind::kPicture) && wish.Wants(TopicKind::kZoom));
  EXPECT_FALSE(wish.Wants(TopicKind::kFrame));
  EXPECT_EQ(wish.camera, 2);
  EXPECT_EQ(wish.region, (PixelRegion{10, 20, 300, 200}));
  ASSERT_TRUE(wish.detail);
  EXPECT_EQ(wish.detail->family, 3);
  EXPECT_EQ(wish.detail->id, (std::uint64_t{1} << 32) + 7);
  EXPECT_EQ(wish.detail->center_px, Eigen::Vector2d(50.5, 60.5));
}

TEST(ClientMessage, RefusesAnythingElse) {
  const std::vector<std::uint8_t> wish = Wish();
  for (std::size_t length = 0; length < 48; ++length)
    EXPECT_FALSE(ParseClientMessage(std::span(wish).first(length))) << length;
  EXPECT_FALSE(ParseClientMessage(std::vector<std::uint8_t>(49, 1)));
  EXPECT_FALSE(ParseClientMessage(With(Wish(), 0, std::uint8_t{9}))) << "another kind";
  EXPECT_FALSE(ParseClientMessage(With(Wish(), 12, std::nanf("")))) << "no number of pixels";
  EXPECT_FALSE(ParseClientMessage(With(Wish(), 20, -1.0F)));
  EXPECT_FALSE(ParseClientMessage(With(Wish(), 20, 1e30F)));
  EXPECT_FALSE(ParseClientMessage(With(Wish(), 28, std::uint8_t{3})));
  EXPECT_FALSE(ParseClientMessage(With(Wish(), 40, std::numeric_limits<float>::infinity())));
  EXPECT_FALSE(ParseClientMessage(With(Wish(), 30, std::uint16_t{60000}))) << "no family";
}

TEST(ClientMessage, SaysWhereAReplayGoesOn) {
  std::vector<std::uint8_t> seek(16);
  seek[0] = 2;
  seek = With(With(seek, 4, 4.0F), 8, 1.7e12);
  const auto message = ParseClientMessage(seek);
  ASSERT_TRUE(message);
  EXPECT_EQ(std::get<PageSeek>(*message).at_ms, 1.7e12);
  EXPECT_EQ(std::get<PageSeek>(*message).speed, 4);
  EXPECT_FALSE(std::get<PageSeek>(*message).playing);
  EXPECT_FALSE(ParseClientMessage(With(seek, 8, std::nan(""))));
  EXPECT_FALSE(ParseClientMessage(With(seek, 8, 1e300)));
  EXPECT_FALSE(ParseClientMessage(With(seek, 4, 0.0F)));
}

TEST(RequestSender, AsksForWhatPagesLookAtTogether) {
  PageWish all{.visible = true,
               .kinds = 1u << static_cast<unsigned>(TopicKind::kPicture),
               .camera = {},
               .picture_width = 320,
               .region = {},
               .detail = {}};
  PageWish one = all;
  one.camera = 1;
  one.picture_width = 640;
  one.kinds |= 1u << static_cast<unsigned>(TopicKind::kZoom);
  one.region = {5, 6, 70, 80};
  one.detail = MarkerChoice{0, 3, {1, 1}};
  PageWish hidden = one;
  hidden.visible = false;
  hidden.camera = 0;
  const CameraAsks first = AsksFor(0, {all, one, hidden}, 100), second = AsksFor(1, {all, one, hidden}, 100);
  EXPECT_EQ(first.whole.preview->width, 320) << "a hidden page asks for nothing";
  EXPECT_FALSE(first.part.preview || first.whole.detail);
  EXPECT_EQ(second.whole.preview->width, 640);
  EXPECT_TRUE(second.whole.preview->region.IsWhole());
  EXPECT_EQ(second.part.preview->region, (PixelRegion{5, 6, 70, 80}));
  EXPECT_EQ(second.part.asker, 101);
  EXPECT_EQ(second.whole.detail->id, 3u);
  EXPECT_FALSE(AsksFor(0, {hidden}, 100).any);
  EXPECT_FALSE(AsksFor(0, {}, 100).any);
}

}  // namespace
}  // namespace chequer
