#include "bench/peer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "bench/contestants.h"

namespace chequer::bench {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

std::vector<Peer> Fake() {
  std::vector<Peer> peers;
  peers.emplace_back(CHEQUER_PEER_FAKE);
  return peers;
}

std::vector<Pattern> PatternsOf(const std::vector<Print>& prints) {
  std::vector<Pattern> patterns;
  for (const Print& print : prints) patterns.push_back(print.pattern);
  return patterns;
}

TEST(Peer, DrawsItsOwnMarkers) {
  const Peer peer(CHEQUER_PEER_FAKE);
  EXPECT_EQ(peer.name(), "fake");
  const std::optional<Print> print = peer.print();
  ASSERT_TRUE(print);
  EXPECT_EQ(print->pattern, "squares");
  const Board board = print->board(5);
  EXPECT_EQ(board.cells, "WWWWWWKWWWKWWWWW") << "bits 0 and 2 of 5 are white";
  EXPECT_EQ(board.uncounted_rim, 1);
  EXPECT_EQ(board.id, 5u);
  EXPECT_EQ(print->board(16 + 5).id, 5u) << "robots beyond its ids get them again";
}

TEST(Peer, JoinsThePrintsOnce) {
  std::vector<Peer> peers = Fake();
  peers.emplace_back(CHEQUER_PEER_FAKE);
  std::vector<Pattern> expected = PatternsOf(KnownPrints());
  EXPECT_EQ(expected.front(), kChequerPattern);
  expected.emplace_back("squares");
  EXPECT_EQ(PatternsOf(PrintsWith(peers)), expected);
}

TEST(Peer, WidestRimIsThatWithTheMostAroundTheSide) {
  EXPECT_EQ(WidestRim(PrintsWith(Fake())).pattern, "squares");  // 4 of 2 cells
  EXPECT_EQ(WidestRim({KnownPrints().front()}).pattern, kChequerPattern);
}

TEST(Peer, TakesPartWithPosesOfItsCorners) {
  const std::vector<Peer> peers = Fake();
  Suite suite;
  suite.side_m = 0.1;
  suite.camera = {.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240};
  const auto contestant = MakePeer(suite, peers.front());
  EXPECT_EQ(contestant->name(), "fake");
  EXPECT_EQ(contestant->pattern(), "squares");
  BenchFrame frame;
  frame.colour = Image(PixelFormat::kBgr8, 640, 480);
  std::fill(frame.colour.bytes().begin(), frame.colour.bytes().end(), std::uint8_t{9});
  contestant->Detect(frame);
  const std::vector<Detection> detections = contestant->Detections();
  ASSERT_EQ(detections.size(), 1u);
  EXPECT_EQ(detections[0].id, 9u) << "of the grey frame's first pixel";
  EXPECT_LT((detections[0].camera_from_marker.translation - Eigen::Vector3d(0, 0, 0.5)).norm(), 1e-5);
  const Eigen::Vector3d outwards = detections[0].camera_from_marker.rotation * Eigen::Vector3d::UnitZ();
  EXPECT_LT((outwards - Eigen::Vector3d(0, -0.6, -0.8)).norm(), 1e-4);
}

TEST(Peer, WithoutADetectorForTheFramesIsRefused) {
  const std::vector<Peer> peers = Fake();
  Suite suite;
  suite.name = "nowhere";
  EXPECT_THAT([&] { MakePeer(suite, peers.front()); },
              ThrowsMessage<std::runtime_error>(HasSubstr("frames of nowhere")));
}

TEST(Peer, OtherLibrariesAreRefused) {
  EXPECT_THAT([] { Peer("no/such.so"); }, ThrowsMessage<std::runtime_error>(HasSubstr("no/such.so")));
  EXPECT_THAT([] { Peer(CHEQUER_PEER_MUTE); },
              ThrowsMessage<std::runtime_error>(HasSubstr("has no function chequer_peer")));
  EXPECT_THAT([] { Peer(CHEQUER_PEER_STALE); }, ThrowsMessage<std::runtime_error>(HasSubstr("made for version 0")));
}

}  // namespace
}  // namespace chequer::bench
