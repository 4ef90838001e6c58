#include "evaluate/recognition.h"

#include <gtest/gtest.h>

#include <array>

namespace chequer {
namespace {

SeenMarker Read(std::uint64_t id, double x = 0) {
  return {id, RigidTransform{Eigen::Quaterniond::Identity(), {x, 0, 1}}};
}

TEST(Recognition, CountsFramesNotDetections) {
  const std::vector<SeenFrame> frames{{Read(7)}, {}, {Read(7), Read(7)}, {SeenMarker{}}, {Read(7), SeenMarker{}}};
  const Recognition counts = CountRecognised(frames, 7);
  EXPECT_EQ(counts.frames, 5);
  EXPECT_EQ(counts.recognised, 3);
  EXPECT_EQ(counts.undecided, 1) << "a frame in which the id was read is not undecided";
  EXPECT_EQ(counts.wrong, 0);
  EXPECT_DOUBLE_EQ(counts.Rate(), 0.6);
}

TEST(Recognition, OtherIdsAreWrongUnlessTheyAreThere) {
  const std::vector<SeenFrame> frames{{Read(7), Read(8)}, {Read(9)}};
  EXPECT_EQ(CountRecognised(frames, 7).wrong, 2);
  EXPECT_EQ(CountRecognised(frames, 7, std::array<std::uint64_t, 1>{8}).wrong, 1);
}

TEST(SeenBeside, TellsOtherMarkersFromMisreadOnes) {
  std::vector<SeenFrame> frames;
  for (int i = 0; i < 20; ++i) {
    SeenFrame frame{Read(7)};
    if (i % 2 == 0) frame.push_back(Read(30));  // another robot, now and then hidden
    frames.push_back(frame);
    frames.push_back({Read(9)});  // the same marker, misread
  }
  frames[0].push_back(Read(99));  // once
  EXPECT_EQ(SeenBeside(frames, 7), std::vector<std::uint64_t>{30});
}

TEST(Recognition, OfNoFramesIsZero) { EXPECT_EQ(CountRecognised({}, 7).Rate(), 0); }

TEST(MostSeen, IsTheIdOfMostDetections) {
  EXPECT_EQ(MostSeen(std::vector<SeenFrame>{{Read(4)}, {Read(7)}, {Read(7)}, {SeenMarker{}}}), 7u);
  EXPECT_EQ(MostSeen(std::vector<SeenFrame>{{Read(9)}, {Read(4)}}), 4u);
  EXPECT_EQ(MostSeen(std::vector<SeenFrame>{{SeenMarker{}}, {}}), std::nullopt);
}

TEST(Poses, AreThoseOfTheIdThatHaveOne) {
  const std::vector<SeenFrame> frames{{Read(4, 0.4), Read(7, 0.1)}, {SeenMarker{7, std::nullopt}}, {Read(7, 0.2)}};
  const auto poses = PosesOf(frames, 7);
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[0].translation.x(), 0.1);
  EXPECT_EQ(poses[1].translation.x(), 0.2);
}

}  // namespace
}  // namespace chequer
