#include "track/tracker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "support/error_of.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;

constexpr milliseconds kFrame{50};

MonotonicTime At(int frame) { return MonotonicTime(kFrame * frame); }

Matrix6d SmallCovariance() {
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal() << Eigen::Vector3d::Constant(1e-8), Eigen::Vector3d::Constant(1e-6);
  return covariance;
}

TrackedPose PoseOf(const TrackKey& key, const Eigen::Vector3d& position) {
  return {key, {Eigen::Quaterniond::Identity(), position}, SmallCovariance()};
}

const TrackKey kAlice{"alice", 0, 7};

/// Alice in a frame: half a metre a second along x.
TrackedPose Alice(int frame) { return PoseOf(kAlice, {0.025 * frame, 0, 0}); }

std::vector<TrackState> TracksAt(const Tracker& tracker, MonotonicTime time) {
  std::vector<TrackState> tracks;
  tracker.Tracks(time, tracks);
  return tracks;
}

/// Follows alice over the frames 0 … last.
Tracker Following(int last, TrackerOptions options = {}) {
  Tracker tracker(options);
  for (int frame = 0; frame <= last; ++frame) tracker.Update(std::vector{Alice(frame)}, At(frame));
  return tracker;
}

TEST(Tracker, TellsVelocityAndAge) {
  const auto tracks = TracksAt(Following(20), At(20));
  ASSERT_EQ(tracks.size(), 1u);
  EXPECT_EQ(tracks[0].key.robot, "alice");
  EXPECT_EQ(tracks[0].key.id, 7u);
  EXPECT_NEAR(tracks[0].velocity.x(), 0.5, 1e-3);
  EXPECT_EQ(tracks[0].age, 20 * kFrame);
  EXPECT_EQ(tracks[0].since_seen, milliseconds(0));
  EXPECT_FALSE(tracks[0].coasting);
  EXPECT_EQ(tracks[0].poses_used, 21u);
  EXPECT_EQ(tracks[0].poses_refused, 0u);
}

TEST(Tracker, PredictsToALaterTime) {
  const Tracker tracker = Following(20);
  const auto now = TracksAt(tracker, At(20));
  const auto later = TracksAt(tracker, At(20) + milliseconds(30));
  EXPECT_NEAR(later[0].frame_from_body.translation.x(), 0.5 + 0.015, 1e-4);
  EXPECT_EQ(later[0].age, 20 * kFrame + milliseconds(30));
  EXPECT_EQ(later[0].since_seen, milliseconds(30));
  EXPECT_FALSE(later[0].coasting) << "the last frame showed it";
  EXPECT_GT(later[0].covariance(0, 0), now[0].covariance(0, 0));
}

TEST(Tracker, CoastsThroughAShortLoss) {
  Tracker tracker = Following(20);
  for (int frame = 21; frame <= 25; ++frame) tracker.Update({}, At(frame));
  const auto tracks = TracksAt(tracker, At(25));
  ASSERT_EQ(tracks.size(), 1u);
  EXPECT_TRUE(tracks[0].coasting);
  EXPECT_EQ(tracks[0].since_seen, 5 * kFrame);
  EXPECT_NEAR(tracks[0].frame_from_body.translation.x(), 0.025 * 25, 1e-3);
  tracker.Update(std::vector{Alice(26)}, At(26));
  const auto again = TracksAt(tracker, At(26));
  EXPECT_FALSE(again[0].coasting);
  EXPECT_EQ(again[0].age, 26 * kFrame) << "it is the same track";
}

TEST(Tracker, EndsATrackAfterALongLoss) {
  Tracker tracker = Following(20, {.coast = milliseconds(200)});
  for (int frame = 21; frame <= 24; ++frame) tracker.Update({}, At(frame));
  EXPECT_EQ(TracksAt(tracker, At(24)).size(), 1u);
  tracker.Update({}, At(25));
  EXPECT_TRUE(TracksAt(tracker, At(25)).empty());
}

TEST(Tracker, OneBadPoseDoesNotDragATrack) {
  Tracker tracker = Following(20);
  tracker.Update(std::vector{PoseOf(kAlice, {1.5, 1, 0})}, At(21));
  const auto tracks = TracksAt(tracker, At(21));
  EXPECT_NEAR(tracks[0].frame_from_body.translation.x(), 0.025 * 21, 1e-3);
  EXPECT_NEAR(tracks[0].velocity.x(), 0.5, 1e-3);
  EXPECT_TRUE(tracks[0].coasting);
  EXPECT_EQ(tracks[0].poses_refused, 1u);
  tracker.Update(std::vector{Alice(22)}, At(22));
  EXPECT_FALSE(TracksAt(tracker, At(22))[0].coasting);
}

TEST(Tracker, AMirroredRotationDoesNotDragATrackEither) {
  Tracker tracker = Following(20);
  TrackedPose mirrored = Alice(21);
  mirrored.frame_from_body.rotation = RotationFromVector({0.8, 0, 0});
  tracker.Update(std::vector{mirrored}, At(21));
  EXPECT_LT(VectorFromRotation(TracksAt(tracker, At(21))[0].frame_from_body.rotation).norm(), 1e-3);
}

TEST(Tracker, BeginsAnewWhereARobotWasCarriedTo) {
  Tracker tracker = Following(20, {.refused_to_restart = 4});
  for (int frame = 21; frame <= 23; ++frame) tracker.Update(std::vector{PoseOf(kAlice, {2, 1, 0})}, At(frame));
  EXPECT_LT(TracksAt(tracker, At(23))[0].frame_from_body.translation.x(), 1);
  tracker.Update(std::vector{PoseOf(kAlice, {2, 1, 0})}, At(24));
  const auto tracks = TracksAt(tracker, At(24));
  ASSERT_EQ(tracks.size(), 1u);
  EXPECT_NEAR(tracks[0].frame_from_body.translation.x(), 2, 1e-3);
  EXPECT_NEAR(tracks[0].velocity.norm(), 0, 1e-2);
  EXPECT_EQ(tracks[0].age, milliseconds(0));
  EXPECT_FALSE(tracks[0].coasting);
}

TEST(Tracker, ScatteredBadPosesAreNoNewPlace) {
  Tracker tracker = Following(4, {.coast = milliseconds(5000), .refused_to_restart = 3});
  for (int frame = 5; frame <= 15; ++frame)
    tracker.Update(std::vector{PoseOf(kAlice, {5.0 + (frame * 7 % 11), 3.0 * (frame % 5), 0})}, At(frame));
  const auto tracks = TracksAt(tracker, At(15));
  EXPECT_NEAR(tracks[0].frame_from_body.translation.x(), 0.025 * 15, 0.02);
  EXPECT_EQ(tracks[0].poses_refused, 11u);
}

TEST(Tracker, OfTwoPosesWithOneNameTheNearerCounts) {
  Tracker tracker = Following(20);
  tracker.Update(std::vector{PoseOf(kAlice, {3, 0, 0}), Alice(21)}, At(21));
  const auto tracks = TracksAt(tracker, At(21));
  ASSERT_EQ(tracks.size(), 1u);
  EXPECT_FALSE(tracks[0].coasting);
  EXPECT_EQ(tracks[0].poses_refused, 0u);
}

TEST(Tracker, KnowsARobotByItsNameWhicheverMarkerShows) {
  Tracker tracker = Following(3);
  TrackedPose other_marker = Alice(4);
  other_marker.key.id = 8;
  tracker.Update(std::vector{other_marker}, At(4));
  EXPECT_EQ(TracksAt(tracker, At(4)).size(), 1u);
}

TEST(Tracker, KeepsManyApartInASteadyOrder) {
  Tracker tracker;
  const std::vector<TrackedPose> poses{PoseOf({"", 1, 2}, {1, 0, 0}), PoseOf({"bob", 0, 9}, {2, 0, 0}),
                                       PoseOf({"", 0, 5}, {3, 0, 0}), PoseOf({"alice", 0, 9}, {4, 0, 0}),
                                       PoseOf({"", 0, 2}, {5, 0, 0})};
  for (int frame = 0; frame < 3; ++frame) tracker.Update(poses, At(frame));
  const auto tracks = TracksAt(tracker, At(2));
  ASSERT_EQ(tracks.size(), 5u);
  const double x[] = {5, 3, 1, 4, 2};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(tracks[i].frame_from_body.translation.x(), x[i], 1e-6) << i;
    EXPECT_EQ(tracks[i].poses_used, 3u);
  }
}

TEST(Tracker, BeginsAnewWhereTimeGoesBack) {
  Tracker tracker = Following(20);
  tracker.Update(std::vector{Alice(0)}, At(0));
  const auto tracks = TracksAt(tracker, At(0));
  ASSERT_EQ(tracks.size(), 1u);
  EXPECT_EQ(tracks[0].age, milliseconds(0));
  EXPECT_EQ(tracks[0].poses_used, 1u);
}

TEST(Tracker, PassesOverWhatIsNotFinite) {
  Tracker tracker = Following(5);
  TrackedPose no_number = Alice(6);
  no_number.frame_from_body.translation.x() = std::numeric_limits<double>::quiet_NaN();
  TrackedPose no_covariance = Alice(6);
  no_covariance.covariance.setZero();
  no_covariance.key.robot = "bob";
  tracker.Update(std::vector{no_number, no_covariance}, At(6));
  const auto tracks = TracksAt(tracker, At(6));
  ASSERT_EQ(tracks.size(), 1u);
  EXPECT_TRUE(tracks[0].frame_from_body.translation.allFinite());
  EXPECT_TRUE(tracks[0].coasting);
}

TEST(Tracker, HasNoTracksBeforeItsFirstFrame) { EXPECT_TRUE(TracksAt(Tracker(), At(3)).empty()); }

TEST(Tracker, SaysWhichOptionIsWrong) {
  const auto wrong = [](TrackerOptions options) { return test::ErrorOf([&] { const Tracker tracker(options); }); };
  EXPECT_EQ(wrong({}), "no error");
  EXPECT_THAT(wrong({.model = {.acceleration_m_s2 = 0}}), HasSubstr("acceleration"));
  EXPECT_THAT(wrong({.model = {.angular_acceleration_rad_s2 = -1}}), HasSubstr("angular_acceleration"));
  EXPECT_THAT(wrong({.gate = 1}), HasSubstr("gate"));
  EXPECT_THAT(wrong({.coast = milliseconds(0)}), HasSubstr("coast"));
  EXPECT_THAT(wrong({.refused_to_restart = 1}), HasSubstr("refused_to_restart"));
}

TEST(Tracker, AveragesNothingAwayThatStaysFromFrameToFrame) {
  Matrix6d print = Matrix6d::Zero();
  print(2, 2) = 1e-6;  // a millimetre of depth
  Tracker exact, printed;
  for (int frame = 0; frame <= 100; ++frame) {
    TrackedPose pose = Alice(frame);
    exact.Update(std::vector{pose}, At(frame));
    pose.covariance += print;
    pose.print_covariance = print;
    printed.Update(std::vector{pose}, At(frame));
  }
  const TrackState without = TracksAt(exact, At(100))[0], with = TracksAt(printed, At(100))[0];
  EXPECT_LT(without.covariance(2, 2), 1e-8);
  EXPECT_NEAR(with.covariance(2, 2), without.covariance(2, 2) + 1e-6, 1e-12);
  EXPECT_EQ(with.frame_from_body.translation, without.frame_from_body.translation);
}

}  // namespace
}  // namespace chequer
