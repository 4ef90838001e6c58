#include "simulate/truth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <stdexcept>

#include "support/error_of.h"

namespace chequer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// A file of this test alone, gone with it.
class TruthFile : public ::testing::Test {
 protected:
  ~TruthFile() override { std::filesystem::remove(path_); }
  const std::filesystem::path path_ =
      std::filesystem::temp_directory_path() /
      ("chequer_truth_" + std::to_string(getpid()) + ::testing::UnitTest::GetInstance()->current_test_info()->name());

  std::string ReadError() {
    return test::ErrorOf([&] { ReadTruth(path_); });
  }
};

std::vector<SceneMarker> TwoMarkers() {
  SceneMarker marker;
  marker.board = MakeBoard(MarkerCode(MarkerSize{10, 10}, Variant::kUnconstrained), 0xfedcba9876543210u);
  marker.side_m = 0.2;
  marker.camera_from_marker = FacingPose({0.1234567891234, -0.05, 1.1}, 2.2, 0.3, 0.4);
  SceneMarker other = marker;
  other.board = MakeBoard(MarkerCode(MarkerSize{4, 6}, Variant::kUnconstrained), 5);
  other.camera_from_marker = FacingPose({-0.2, 0.1, 1.5}, -1);
  return {marker, other};
}

const CameraModel kCamera{.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240};

TEST_F(TruthFile, RoundTripsWhatStreamsAdd) {
  FrameTruth frame{"a.png", TruthOf(TwoMarkers(), kCamera)};
  frame.phase = "knock";
  frame.time_s = 1.25;
  frame.markers[0].inside = 0.75;
  frame.markers[0].visible = 0.5;
  frame.markers[0].motion_px = 7.5;
  WriteTruth(path_, {frame});
  const FrameTruth read = ReadTruth(path_).at(0);
  EXPECT_EQ(read.phase, "knock");
  EXPECT_EQ(read.time_s, 1.25);
  EXPECT_EQ(read.markers[0].inside, 0.75);
  EXPECT_EQ(read.markers[0].visible, 0.5);
  EXPECT_EQ(read.markers[0].motion_px, 7.5);
  EXPECT_EQ(ToJsonLine({"b.png", {}}), R"({"file":"b.png","markers":[]})") << "others stay as they were";
}

TEST_F(TruthFile, RoundTripsEveryField) {
  const FrameTruth frame{"a.png", TruthOf(TwoMarkers(), kCamera)};
  ASSERT_EQ(frame.markers.size(), 2u);
  WriteTruth(path_, {frame, {"empty.png", {}}});
  const auto frames = ReadTruth(path_);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].file, "a.png");
  EXPECT_EQ(frames[1].file, "empty.png");
  EXPECT_TRUE(frames[1].markers.empty());
  ASSERT_EQ(frames[0].markers.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const TrueMarker &read = frames[0].markers[i], &written = frame.markers[i];
    EXPECT_EQ(read.id, written.id);
    EXPECT_EQ(read.variant, written.variant);
    EXPECT_EQ(read.size, written.size);
    EXPECT_EQ(read.side_m, written.side_m);
    EXPECT_EQ(read.camera_from_marker.translation, written.camera_from_marker.translation);
    EXPECT_LT(read.camera_from_marker.rotation.angularDistance(written.camera_from_marker.rotation), 1e-7);
    EXPECT_EQ(read.center_px, written.center_px);
    EXPECT_EQ(read.cell_px, written.cell_px);
  }
}

TEST_F(TruthFile, FaultsAreNamedWithFileAndLine) {
  EXPECT_THAT(ReadError(), AllOf(HasSubstr(path_.string()), HasSubstr("cannot be opened")));
  std::ofstream(path_) << R"({"file":"a.png","markers":[]})"
                       << "\n\n"
                       << R"({"file":"b.png","markers":[{"id":-}]})"
                       << "\n";
  EXPECT_THAT(ReadError(), AllOf(HasSubstr(path_.string()), HasSubstr("line 3")));
  std::ofstream(path_) << R"({"file":"a.png"})"
                       << "\n";
  EXPECT_THAT(ReadError(), AllOf(HasSubstr("line 1"), HasSubstr("markers")));
}

TEST(WriteTruth, UnwritablePlaceIsNamed) { EXPECT_THROW(WriteTruth("/nowhere/truth.jsonl", {}), std::runtime_error); }

TEST(TruthOf, LeavesOutWhatIsNotWhollySeen) {
  auto markers = TwoMarkers();
  markers[0].camera_from_marker.translation.x() = 0.7;
  markers[1].camera_from_marker.translation.z() = -1;
  EXPECT_TRUE(TruthOf(markers, kCamera).empty());
}

TEST(TruthOf, PeersCountTheirBlackSquareOnly) {
  if (!HasAprilTag()) GTEST_SKIP() << "built without libapriltag";
  auto markers = TwoMarkers();
  markers[0].board = AprilTag36h11(7);
  const auto truth = TruthOf(markers, kCamera);
  EXPECT_EQ(truth[0].size, (MarkerSize{8, 8}));
  EXPECT_EQ(truth[0].variant, "tag36h11");
}

}  // namespace
}  // namespace chequer
