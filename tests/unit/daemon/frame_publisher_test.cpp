#include "daemon/frame_publisher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "support/recording_publisher.h"
#include "unit/robot/measured_boards.h"

namespace chequer {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using test::Detect;
using test::OnFloor;
using test::WorldFromCamera;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kHeight = 0.1;

WorldCalibration World() {
  WorldCalibration world;
  world.world_from_camera = WorldFromCamera();
  return world;
}

RobotRoster Roster() {
  const RosterMarker marker{
      .id = 3, .family = 0, .body_from_marker = {Eigen::Quaterniond::Identity(), {0, 0, kHeight}}};
  return {{{.name = "alice", .markers = {marker}, .body_height_m = 0}}};
}

/// A marker as a camera sees it on a robot.
MarkerPose On(std::uint64_t id, const RigidTransform& world_from_body) {
  return Detect(id, WorldFromCamera().Inverse() * world_from_body *
                        RigidTransform{Eigen::Quaterniond::Identity(), {0, 0, kHeight}});
}

class FramePublisherTest : public ::testing::Test {
 protected:
  /// Publishes a frame with these markers; frames are 50 ms apart, and published 8 ms after their capture.
  void Publish(FramePublisher& frames, std::vector<MarkerPose> markers) {
    PosesMessage message;
    message.captured_utc = UtcTime(captured_);
    message.captured_monotonic = MonotonicTime(captured_);
    message.sequence = sequence_++;
    message.camera = "ceiling";
    message.markers = std::move(markers);
    frames.Publish(message, publisher_, clock_);
    captured_ += milliseconds(50);
  }

  std::shared_ptr<test::Published> published_ = std::make_shared<test::Published>();
  test::RecordingPublisher publisher_{published_};
  microseconds captured_{1'000'000};
  std::uint64_t sequence_ = 0;
  Clock clock_{[this] { return UtcTime(captured_ + milliseconds(8)); },
               [this] { return MonotonicTime(captured_ + milliseconds(8)); }};
};

TEST_F(FramePublisherTest, PublishesPosesAloneWhereNothingElseIsWanted) {
  FramePublisher frames({});
  Publish(frames, {On(3, OnFloor(0, 0, 0))});
  ASSERT_EQ(published_->poses().size(), 1u);
  EXPECT_EQ(published_->poses()[0].frame, "camera");
  EXPECT_TRUE(published_->robots().empty());
  EXPECT_TRUE(published_->tracks().empty());
  EXPECT_TRUE(published_->in_camera().empty());
  EXPECT_TRUE(frames.TakeCounts().empty());
}

TEST_F(FramePublisherTest, PublishesInTheWorldInTheCameraOrInBoth) {
  const RigidTransform truth = OnFloor(0.3, -0.4, 0.5);
  const MarkerPose seen = On(3, truth);
  for (const PublishedFrames choice : {PublishedFrames::kWorld, PublishedFrames::kCamera, PublishedFrames::kBoth}) {
    FramePublisher frames({.world = World(), .frames = choice});
    Publish(frames, {seen});
  }
  const auto poses = published_->poses();
  ASSERT_EQ(poses.size(), 3u);
  EXPECT_EQ(poses[0].frame, "world");
  EXPECT_EQ(poses[1].frame, "camera");
  EXPECT_EQ(poses[2].frame, "world");
  const RigidTransform& in_world = poses[0].markers[0].camera_from_marker;
  EXPECT_LT((in_world.translation - Eigen::Vector3d(0.3, -0.4, kHeight)).norm(), 1e-5);
  EXPECT_LT(VectorFromRotation(in_world.rotation * truth.rotation.conjugate()).norm(), 1e-4);
  EXPECT_EQ(poses[1].markers[0].camera_from_marker.translation, seen.camera_from_marker.translation);
  ASSERT_EQ(published_->in_camera().size(), 1u);
  EXPECT_EQ(published_->in_camera()[0].frame, "camera");
  EXPECT_EQ(published_->in_camera()[0].markers[0].camera_from_marker.translation, seen.camera_from_marker.translation);
}

TEST_F(FramePublisherTest, TurnsTheCovarianceIntoTheWorldToo) {
  MarkerPose marker = On(3, OnFloor(0.3, -0.4, 0.5));
  const Matrix6d before = marker.covariance;
  MoveInto(WorldFromCamera(), marker);
  // What is not known is the distance: along the line of sight, which is about the world's z.
  Eigen::Index worst = 0;
  marker.covariance.diagonal().head<3>().maxCoeff(&worst);
  EXPECT_EQ(worst, 2);
  EXPECT_NEAR(marker.covariance.trace(), before.trace(), 1e-12);
  const Eigen::Vector3d sight =
      WorldFromCamera().rotation * (WorldFromCamera().Inverse() * Eigen::Vector3d(0.3, -0.4, kHeight)).normalized();
  const Eigen::Vector3d in_camera = WorldFromCamera().rotation.conjugate() * sight;
  EXPECT_NEAR(sight.dot(marker.covariance.topLeftCorner<3, 3>() * sight),
              in_camera.dot(before.topLeftCorner<3, 3>() * in_camera), 1e-15);
}

TEST_F(FramePublisherTest, NamesRobotsAndMeasuresThemOnTheFloor) {
  FramePublisher frames({.world = World(), .roster = Roster(), .floor_mode = true});
  Publish(frames, {On(3, OnFloor(0.3, -0.4, 0.5)), On(9, OnFloor(0, 0, 0))});
  ASSERT_EQ(published_->robots().size(), 1u);
  const RobotsMessage message = published_->robots()[0];
  EXPECT_EQ(message.header.frame, "world");
  EXPECT_EQ(message.header.camera, "ceiling");
  EXPECT_EQ(message.header.published_monotonic - message.header.captured_monotonic, milliseconds(8));
  ASSERT_EQ(message.robots.size(), 1u);
  EXPECT_EQ(message.robots[0].name, "alice");
  EXPECT_LT((message.robots[0].floor.value().position - Eigen::Vector2d(0.3, -0.4)).norm(), 1e-6);
  EXPECT_EQ(published_->poses()[0].markers.size(), 2u) << "others are not ignored unless that was asked for";
  EXPECT_EQ(published_->poses()[0].markers[0].id, 3u);
}

TEST_F(FramePublisherTest, LeavesOutWhatNoRobotBearsWhereAsked) {
  FramePublisher frames({.world = World(), .roster = Roster(), .ignore_others = true});
  MarkerPose undecided = On(9, OnFloor(0.2, 0, 0));
  undecided.id.reset();
  Publish(frames, {On(3, OnFloor(0.3, -0.4, 0.5)), On(9, OnFloor(0, 0, 0)), undecided});
  const auto markers = published_->poses()[0].markers;
  ASSERT_EQ(markers.size(), 2u);
  EXPECT_EQ(markers[0].id, 3u);
  EXPECT_FALSE(markers[1].id.has_value()) << "an undecided one may be a robot's";
  const auto counts = frames.TakeCounts();
  ASSERT_EQ(counts.size(), 2u);
  EXPECT_EQ(counts[0].name, "outside_roster");
  EXPECT_EQ(counts[0].count, 1u);
  EXPECT_EQ(counts[1].name, "robots");
  EXPECT_EQ(counts[1].count, 1u);
  EXPECT_EQ(frames.TakeCounts()[0].count, 0u) << "since the last call";
}

TEST_F(FramePublisherTest, FollowsRobotsFromTheFloor) {
  FramePublisher frames({.world = World(), .roster = Roster(), .floor_mode = true, .tracks = true});
  for (int i = 0; i < 20; ++i) Publish(frames, {On(3, OnFloor(0.02 * i, 0, 0.5))});
  Publish(frames, {});
  const auto tracks = published_->tracks();
  ASSERT_EQ(tracks.size(), 21u);
  const TrackState& moving = tracks[19].tracks.at(0);
  EXPECT_EQ(moving.key.robot, "alice");
  EXPECT_NEAR(moving.velocity.x(), 0.4, 1e-3);
  EXPECT_NEAR(moving.velocity.y(), 0, 1e-3);
  EXPECT_NEAR(moving.frame_from_body.translation.z(), 0, 1e-3);
  EXPECT_EQ(tracks[19].valid_monotonic, tracks[19].header.captured_monotonic);
  const TrackState& coasting = tracks[20].tracks.at(0);
  EXPECT_TRUE(coasting.coasting);
  EXPECT_NEAR(coasting.frame_from_body.translation.x(), 0.4, 1e-3);
  EXPECT_TRUE(published_->robots()[20].robots.empty()) << "what is not seen is not measured";
}

TEST_F(FramePublisherTest, PredictsTracksToTheTimeOfPublishingWhereAsked) {
  FramePublisher frames({.world = World(), .roster = Roster(), .tracks = true, .track_time = TrackTime::kPublish});
  for (int i = 0; i < 20; ++i) Publish(frames, {On(3, OnFloor(0.02 * i, 0, 0.5))});
  const TracksMessage last = published_->tracks().back();
  EXPECT_EQ(last.valid_monotonic - last.header.captured_monotonic, milliseconds(8));
  EXPECT_EQ(last.valid_utc, last.header.published_utc);
  EXPECT_NEAR(last.tracks.at(0).frame_from_body.translation.x(), 0.38 + 0.4 * 0.008, 1e-3);
  EXPECT_NEAR(published_->robots().back().robots[0].frame_from_body.translation.x(), 0.38, 1e-4) << "it stays raw";
}

TEST_F(FramePublisherTest, FollowsMarkersWhereThereIsNoRoster) {
  FramePublisher frames({.world = World(), .tracks = true});
  for (int i = 0; i < 5; ++i) Publish(frames, {On(9, OnFloor(0, 0.01 * i, 0)), On(3, OnFloor(0.5, 0, 0))});
  const TracksMessage last = published_->tracks().back();
  ASSERT_EQ(last.tracks.size(), 2u);
  EXPECT_EQ(last.header.frame, "world");
  EXPECT_EQ(last.tracks[0].key.id, 3u);
  EXPECT_EQ(last.tracks[0].key.robot, "");
  EXPECT_EQ(last.tracks[1].key.id, 9u);
  EXPECT_NEAR(last.tracks[1].frame_from_body.translation.z(), kHeight, 1e-3);
  EXPECT_TRUE(published_->robots().empty());
}

TEST_F(FramePublisherTest, AFallenRobotIsFollowedByItsFreePose) {
  FramePublisher frames({.world = World(), .roster = Roster(), .floor_mode = true, .tracks = true});
  const RigidTransform fallen{RotationFromVector({0.8, 0, 0}), {0.1, 0.1, 0.05}};
  for (int i = 0; i < 3; ++i) Publish(frames, {On(3, fallen)});
  EXPECT_TRUE(published_->robots().back().robots[0].floor->off_floor);
  const TrackState track = published_->tracks().back().tracks.at(0);
  EXPECT_NEAR(track.frame_from_body.translation.z(), 0.05, 1e-3);
  EXPECT_NEAR(VectorFromRotation(track.frame_from_body.rotation).x(), 0.8, 1e-2);
  const auto counts = frames.TakeCounts();
  EXPECT_EQ(counts[1].name, "off_floor");
  EXPECT_EQ(counts[1].count, 3u);
}

TEST_F(FramePublisherTest, TellsThatTheCameraWasKnocked) {
  WorldCalibration world = World();
  WorldReference reference;
  reference.id = 7;
  reference.side_m = 0.12;
  reference.world_from_marker = OnFloor(0.2, 0.2, 0);
  world.references.push_back(reference);
  FramePublisher frames({.world = world, .drift = {.limit_m = 0.005, .window = milliseconds(200)}});
  const MarkerPose in_place = Detect(7, WorldFromCamera().Inverse() * OnFloor(0.2, 0.2, 0));
  const MarkerPose moved = Detect(7, WorldFromCamera().Inverse() * OnFloor(0.23, 0.2, 0));
  for (int i = 0; i < 20; ++i) Publish(frames, {in_place});
  EXPECT_EQ(frames.trouble(), "");
  for (int i = 0; i < 40; ++i) Publish(frames, {moved});
  EXPECT_THAT(frames.trouble(), HasSubstr("7"));
  for (int i = 0; i < 80; ++i) Publish(frames, {in_place});
  EXPECT_EQ(frames.trouble(), "");
}

}  // namespace
}  // namespace chequer
