// Boards that were found twice.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "detect/boards/boards.h"
#include "support/stress_frames.h"

namespace chequer {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

/// A board whose box is 60 px a side.
SeenBoard At(std::size_t index, double x, double y, int corners, double rms_px, bool has_id = true) {
  SeenBoard board{index, {x, y}, {}, {6, 6}, Eigen::Matrix3d::Identity(), has_id, corners, rms_px};
  board.plane_from_board.topLeftCorner<2, 2>() *= 10;
  board.plane_from_board.topRightCorner<2, 1>() = board.center_px;
  board.box.Add(static_cast<float>(x) - 30, static_cast<float>(y) - 30);
  board.box.Add(static_cast<float>(x) + 30, static_cast<float>(y) + 30);
  return board;
}

TEST(Twins, TheBetterKnownStays) {
  std::vector<SeenBoard> seen{At(0, 100, 100, 25, 0.01), At(1, 300, 100, 20, 0.01), At(2, 300.5, 101, 22, 0.05),
                              At(3, 101, 99, 25, 0.08), At(4, 303, 108, 25, 0.01, false)};
  std::vector<std::size_t> worse;
  TakeOutTwins(seen, worse);
  std::sort(worse.begin(), worse.end());
  EXPECT_THAT(worse, ElementsAre(1, 3, 4));
  ASSERT_THAT(seen, SizeIs(2));
  EXPECT_EQ(seen[0].index, 0u);
  EXPECT_EQ(seen[1].index, 2u);
}

TEST(Twins, NoBoardWithoutAnIdLiesOnOneThatWasRead) {
  // Two cells off, the corners of a board fit those of another. Two with ids may lie one on the other.
  std::vector<SeenBoard> seen{At(0, 100, 100, 25, 0.01), At(1, 120, 120, 15, 0.01, false),
                              At(2, 160, 100, 25, 0.01, false), At(3, 300, 100, 25, 0.01), At(4, 320, 120, 15, 0.01)};
  std::vector<std::size_t> worse;
  TakeOutTwins(seen, worse);
  EXPECT_THAT(worse, ElementsAre(1));
}

TEST(Twins, NoBoardLiesOnAnotherOneIfNeitherWasRead) {
  // A strip between columns leaves two groups of corners. By one of them alone, a board was found two cells off and
  // turned by half, beside that of both.
  std::vector<SeenBoard> seen{At(0, 100, 100, 15, 0.01, false), At(1, 118, 106, 25, 0.07, false)};
  std::vector<std::size_t> worse;
  TakeOutTwins(seen, worse);
  EXPECT_THAT(worse, ElementsAre(0));
}

TEST(Twins, BoardsThatTouchAreNone) {
  // Turned by 45 degrees, boards of 42 px have boxes of 60 px, and those that touch lie 30 px off along both axes.
  std::vector<SeenBoard> seen;
  for (std::size_t i = 0; i < 100; ++i)
    seen.push_back(At(i, 30.0 * static_cast<double>(i % 10), 30.0 * static_cast<double>(i / 10 * 2 + i % 2), 25, 0.01));
  std::vector<std::size_t> worse;
  TakeOutTwins(seen, worse);
  EXPECT_THAT(worse, IsEmpty());
  EXPECT_THAT(seen, SizeIs(100));
}

TEST(Twins, AreNotReported) {
  // Both were: by two levels of a blurred image, and by two groups of corners.
  const MarkerCode code({6, 6}, Variant::kSecded);
  struct Frame {
    const char* tag;
    std::uint64_t seed;
    PixelFormat format;
  };
  for (const Frame& frame :
       {Frame{"motion_px=8", 2, PixelFormat::kBgr8}, Frame{"side_px=24", 27, PixelFormat::kBayerRg8}}) {
    StressCase stress = test::CaseOf(frame.tag, code, frame.seed);
    stress.options.format = frame.format;
    const auto markers = test::Look(stress, code, frame.seed);
    ASSERT_THAT(markers, SizeIs(1)) << frame.tag;
    EXPECT_EQ(markers[0].id, stress.scene.markers[0].board.id);
  }
}

}  // namespace
}  // namespace chequer
