#include "publish/wire.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "unit/publish/messages.h"

namespace chequer {
namespace {

using test::SamplePoses;
using test::SampleRobots;
using test::SampleStatus;
using test::SampleTracks;

std::vector<std::uint8_t> Encoded(const auto& message) {
  WireEncoder encoder;
  const auto bytes = encoder.Encode(message);
  return {bytes.begin(), bytes.end()};
}

PosesMessage RoundTrip(const PosesMessage& message) {
  const auto received = DecodeMessage(Encoded(message));
  EXPECT_TRUE(received.has_value());
  return std::get<PosesMessage>(received.value());
}

std::uint64_t Fingerprint(const std::vector<std::uint8_t>& bytes) {
  std::uint64_t value = 0;
  for (int i = 0; i < 8; ++i) value = value << 8 | bytes.at(static_cast<std::size_t>(i));
  return value;
}

// Programs in the field were built from the installed .lcm files: a type of these names with another fingerprint is one
// they silently drop. A change that breaks this test must be a new type instead.
TEST(Wire, KeepsTheTypesThatProgramsWereBuiltWith) {
  EXPECT_EQ(Fingerprint(Encoded(SamplePoses(1))), 0x67e21677ed0e6abdu);
  EXPECT_EQ(Fingerprint(Encoded(SampleStatus())), 0x1c51dae62dcf16ebu);
  EXPECT_EQ(Fingerprint(Encoded(SampleRobots(1))), 0x9ab63ffebb200f54u);
  EXPECT_EQ(Fingerprint(Encoded(SampleTracks(1))), 0x4385217552b0a3d9u);
}

TEST(Wire, CarriesEveryFieldOfAFrame) {
  const PosesMessage sent = SamplePoses(2);
  const PosesMessage received = RoundTrip(sent);
  EXPECT_EQ(received.captured_utc, sent.captured_utc);
  EXPECT_EQ(received.captured_monotonic, sent.captured_monotonic);
  EXPECT_EQ(received.instant, sent.instant);
  EXPECT_EQ(received.published_utc, sent.published_utc);
  EXPECT_EQ(received.published_monotonic, sent.published_monotonic);
  EXPECT_EQ(received.sequence, sent.sequence);
  EXPECT_EQ(received.frames_dropped, sent.frames_dropped);
  EXPECT_EQ(received.camera, sent.camera);
  EXPECT_EQ(received.frame, sent.frame);
  EXPECT_EQ(received.image_width, sent.image_width);
  EXPECT_EQ(received.image_height, sent.image_height);
  EXPECT_EQ(received.markers.size(), 2u);
}

TEST(Wire, CarriesEveryFieldOfAMarker) {
  const MarkerPose sent = SamplePoses(2).markers[1];
  const MarkerPose received = RoundTrip(SamplePoses(2)).markers[1];
  EXPECT_EQ(received.id, sent.id);
  EXPECT_EQ(received.family, sent.family);
  EXPECT_EQ(received.variant, sent.variant);
  EXPECT_EQ(received.size, sent.size);
  EXPECT_TRUE(received.has_pose);
  EXPECT_EQ(received.camera_from_marker.translation, sent.camera_from_marker.translation);
  EXPECT_EQ(received.camera_from_marker.rotation.coeffs(), sent.camera_from_marker.rotation.coeffs());
  EXPECT_TRUE(received.covariance.isApprox(sent.covariance, 1e-6)) << received.covariance;
  EXPECT_EQ(received.ambiguity, sent.ambiguity);
  EXPECT_TRUE(std::isnan(received.corners[0].x()));
  EXPECT_EQ(received.corners_used, sent.corners_used);
  EXPECT_EQ(received.reprojection_rms_px, sent.reprojection_rms_px);
  EXPECT_EQ(received.center_px, sent.center_px);
  EXPECT_EQ(received.luminance_overlap, sent.luminance_overlap);
  EXPECT_EQ(received.saturation_overlap, sent.saturation_overlap);
  EXPECT_EQ(received.bits_corrected, sent.bits_corrected);
  EXPECT_EQ(received.warnings, sent.warnings);
}

void ExpectSameHeader(const FrameHeader& received, const FrameHeader& sent) {
  EXPECT_EQ(received.captured_utc, sent.captured_utc);
  EXPECT_EQ(received.captured_monotonic, sent.captured_monotonic);
  EXPECT_EQ(received.instant, sent.instant);
  EXPECT_EQ(received.published_utc, sent.published_utc);
  EXPECT_EQ(received.published_monotonic, sent.published_monotonic);
  EXPECT_EQ(received.sequence, sent.sequence);
  EXPECT_EQ(received.camera, sent.camera);
  EXPECT_EQ(received.frame, sent.frame);
}

TEST(Wire, CarriesEveryFieldOfARobot) {
  const RobotsMessage message = SampleRobots(2);
  const auto received = std::get<RobotsMessage>(DecodeMessage(Encoded(message)).value());
  ExpectSameHeader(received.header, message.header);
  ASSERT_EQ(received.robots.size(), 2u);
  const RobotPose& robot = received.robots[1];
  const RobotPose& sent = message.robots[1];
  EXPECT_EQ(robot.name, "robot 1");
  EXPECT_EQ(robot.ids, sent.ids);
  EXPECT_EQ(robot.marker_count, 2);
  EXPECT_EQ(robot.family, sent.family);
  EXPECT_EQ(robot.frame_from_body.translation, sent.frame_from_body.translation);
  EXPECT_EQ(robot.frame_from_body.rotation.coeffs(), sent.frame_from_body.rotation.coeffs());
  EXPECT_TRUE(robot.covariance.isApprox(sent.covariance, 1e-6));
  EXPECT_EQ(robot.ambiguity, sent.ambiguity);
  ASSERT_TRUE(robot.floor.has_value());
  EXPECT_EQ(robot.floor->position, sent.floor->position);
  EXPECT_EQ(robot.floor->heading_rad, sent.floor->heading_rad);
  EXPECT_EQ(robot.floor->covariance, sent.floor->covariance);
  EXPECT_EQ(robot.floor->height_error_m, sent.floor->height_error_m);
  EXPECT_EQ(robot.floor->tilt_rad, sent.floor->tilt_rad);
  EXPECT_EQ(robot.floor->chi_square, sent.floor->chi_square);
  EXPECT_TRUE(robot.floor->off_floor);
}

TEST(Wire, SaysWhereARobotHasNoFloorPose) {
  RobotsMessage message = SampleRobots(1);
  message.robots[0].floor.reset();
  message.robots[0].marker_count = 1;
  const auto received = std::get<RobotsMessage>(DecodeMessage(Encoded(message)).value());
  EXPECT_FALSE(received.robots[0].floor.has_value());
  EXPECT_EQ(received.robots[0].marker_count, 1);
}

TEST(Wire, CarriesEveryFieldOfATrack) {
  const TracksMessage message = SampleTracks(2);
  const auto received = std::get<TracksMessage>(DecodeMessage(Encoded(message)).value());
  ExpectSameHeader(received.header, message.header);
  EXPECT_EQ(received.valid_utc, message.valid_utc);
  EXPECT_EQ(received.valid_monotonic, message.valid_monotonic);
  ASSERT_EQ(received.tracks.size(), 2u);
  const TrackState& track = received.tracks[1];
  const TrackState& sent = message.tracks[1];
  EXPECT_EQ(track.key.robot, sent.key.robot);
  EXPECT_EQ(track.key.family, sent.key.family);
  EXPECT_EQ(track.key.id, sent.key.id);
  EXPECT_EQ(track.frame_from_body.translation, sent.frame_from_body.translation);
  EXPECT_EQ(track.frame_from_body.rotation.coeffs(), sent.frame_from_body.rotation.coeffs());
  EXPECT_EQ(track.velocity, sent.velocity);
  EXPECT_EQ(track.angular_velocity, sent.angular_velocity);
  using Block = Eigen::Matrix<double, 6, 6>;
  EXPECT_EQ(Block(track.covariance.topLeftCorner<6, 6>()), Block(sent.covariance.topLeftCorner<6, 6>()));
  EXPECT_EQ(Block(track.covariance.bottomRightCorner<6, 6>()), Block(sent.covariance.bottomRightCorner<6, 6>()));
  EXPECT_EQ(track.age, sent.age);
  EXPECT_EQ(track.since_seen, sent.since_seen);
  EXPECT_TRUE(track.coasting);
  EXPECT_EQ(track.poses_used, sent.poses_used);
  EXPECT_EQ(track.poses_refused, sent.poses_refused);
}

TEST(Wire, RefusesRobotsAndTracksThatAreCutOff) {
  for (const auto& bytes : {Encoded(SampleRobots(2)), Encoded(SampleTracks(2))})
    for (std::size_t size = 0; size < bytes.size(); size += 7)
      EXPECT_FALSE(DecodeMessage(std::span(bytes).first(size)).has_value()) << size;
}

TEST(Wire, RefusesARobotWithMoreMarkersThanThereCanBe) {
  std::vector<std::uint8_t> bytes = Encoded(SampleRobots(1));
  const std::string name = "robot 0";
  // A text is followed by a zero; what comes next is the count of markers.
  const auto found = std::search(bytes.begin(), bytes.end(), name.begin(), name.end());
  ASSERT_NE(found, bytes.end());
  std::uint8_t& count = *(found + static_cast<std::ptrdiff_t>(name.size()) + 1);
  ASSERT_EQ(count, 2);
  for (const int wrong : {3, 100, 255}) {
    count = static_cast<std::uint8_t>(wrong);
    EXPECT_FALSE(DecodeMessage(bytes).has_value()) << wrong;
  }
}

TEST(Wire, CarriesEveryFieldOfTheStatus) {
  const StatusMessage sent = SampleStatus();
  const StatusMessage received = std::get<StatusMessage>(DecodeMessage(Encoded(sent)).value());
  EXPECT_EQ(received.utc, sent.utc);
  EXPECT_EQ(received.monotonic, sent.monotonic);
  EXPECT_EQ(received.uptime, sent.uptime);
  EXPECT_EQ(received.version, sent.version);
  EXPECT_EQ(received.camera, sent.camera);
  EXPECT_EQ(received.camera_state, sent.camera_state);
  EXPECT_EQ(received.camera_source, sent.camera_source);
  EXPECT_EQ(received.camera_message, sent.camera_message);
  EXPECT_EQ(received.publisher.state, sent.publisher.state);
  EXPECT_EQ(received.publisher.message, sent.publisher.message);
  EXPECT_EQ(received.publisher.sent, sent.publisher.sent);
  EXPECT_EQ(received.publisher.failed, sent.publisher.failed);
  EXPECT_EQ(received.window, sent.window);
  EXPECT_EQ(received.capture_rate_hz, sent.capture_rate_hz);
  EXPECT_EQ(received.publish_rate_hz, sent.publish_rate_hz);
  EXPECT_EQ(received.frames_captured, sent.frames_captured);
  EXPECT_EQ(received.frames_published, sent.frames_published);
  EXPECT_EQ(received.frames_dropped, sent.frames_dropped);
  EXPECT_EQ(received.queue_depth, sent.queue_depth);
  EXPECT_EQ(received.queue_capacity, sent.queue_capacity);
  EXPECT_EQ(received.workers, sent.workers);
  EXPECT_EQ(received.markers_mean, sent.markers_mean);
  EXPECT_EQ(received.markers_min, sent.markers_min);
  EXPECT_EQ(received.markers_max, sent.markers_max);
  ASSERT_EQ(received.drops.size(), 2u);
  EXPECT_EQ(received.drops[1].name, "superseded");
  EXPECT_EQ(received.drops[1].count, 3u);
  ASSERT_EQ(received.stages.size(), 1u);
  EXPECT_EQ(received.stages[0].stage, "detect");
  EXPECT_EQ(received.stages[0].frames, 60u);
  EXPECT_EQ(received.stages[0].median, sent.stages[0].median);
  EXPECT_EQ(received.stages[0].p99, sent.stages[0].p99);
  EXPECT_EQ(received.stages[0].worst, sent.stages[0].worst);
  ASSERT_EQ(received.detections.size(), 1u);
  EXPECT_EQ(received.detections[0].name, "boards");
  EXPECT_EQ(received.detections[0].count, 3000u);
}

TEST(Wire, KeepsAll64BitsOfAnId) {
  PosesMessage message = SamplePoses(2);
  message.markers[0].id = std::numeric_limits<std::uint64_t>::max();
  message.markers[1].id = 1ull << 63;
  const PosesMessage received = RoundTrip(message);
  EXPECT_EQ(received.markers[0].id, std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(received.markers[1].id, 1ull << 63);
}

TEST(Wire, SendsAnUndecidedIdAsNone) {
  PosesMessage message = SamplePoses(1);
  message.markers[0].id.reset();
  const PosesMessage received = RoundTrip(message);
  EXPECT_FALSE(received.markers[0].id.has_value());
  EXPECT_EQ(received.markers[0].bits_corrected, 0);
}

TEST(Wire, SendsAMissingPoseAsNotANumber) {
  PosesMessage with = SamplePoses(1);
  PosesMessage without = with;
  without.markers[0].has_pose = false;
  EXPECT_FALSE(RoundTrip(without).markers[0].has_pose);
  // The bytes of the position of a reader that does not look at pose_valid: id, four flags, family, pose_valid before.
  const auto offset = [](const std::vector<std::uint8_t>& bytes) { return bytes.size() - 187 + 15; };
  const auto position_x = [&](const std::vector<std::uint8_t>& bytes) {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < 8; ++i) bits = bits << 8 | bytes[offset(bytes) + i];
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  };
  EXPECT_EQ(position_x(Encoded(with)), 0.25);
  EXPECT_TRUE(std::isnan(position_x(Encoded(without))));
}

TEST(Wire, SendsRotationsWithPositiveW) {
  PosesMessage message = SamplePoses(1);
  Eigen::Quaterniond& q = message.markers[0].camera_from_marker.rotation;
  q.coeffs() = -q.coeffs();
  EXPECT_GT(RoundTrip(message).markers[0].camera_from_marker.rotation.w(), 0);
}

// A kernel's stock receive buffer (rmem_default 212992) carries messages of 200 kB at 60 a second and loses those of
// 300 kB.
TEST(Wire, KeepsAThousandMarkersBelowWhatAStockBufferCarries) {
  EXPECT_LE(Encoded(SamplePoses(1000)).size(), 200'000u);
}

TEST(Wire, CarriesAFrameWithoutMarkers) { EXPECT_TRUE(RoundTrip(SamplePoses(0)).markers.empty()); }

TEST(Wire, ShrinksAgainAfterAFullFrame) {
  WireEncoder encoder;
  encoder.Encode(SamplePoses(50));
  const auto bytes = encoder.Encode(SamplePoses(1));
  EXPECT_EQ(std::get<PosesMessage>(DecodeMessage(bytes).value()).markers.size(), 1u);
}

TEST(Wire, RefusesWhatIsCutOffAnywhere) {
  const std::vector<std::uint8_t> bytes = Encoded(SamplePoses(2));
  for (std::size_t length = 0; length < bytes.size(); ++length)
    EXPECT_FALSE(DecodeMessage(std::span(bytes).first(length)).has_value()) << length;
}

TEST(Wire, RefusesOtherTypes) {
  std::vector<std::uint8_t> bytes = Encoded(SamplePoses(1));
  bytes[7] ^= 1;  // of the fingerprint
  EXPECT_FALSE(DecodeMessage(bytes).has_value());
}

TEST(Wire, CarriesAVariantThatItDoesNotKnow) {
  std::vector<std::uint8_t> bytes = Encoded(SamplePoses(2));
  const std::size_t variant = bytes.size() - 2 * 187 + 9;
  for (const std::uint8_t newer : std::array<std::uint8_t, 3>{8, 120, 255}) {
    bytes[variant] = newer;
    const auto message = DecodeMessage(bytes);
    ASSERT_TRUE(message.has_value());
    const std::vector<MarkerPose>& markers = std::get<PosesMessage>(*message).markers;
    ASSERT_EQ(markers.size(), 2u);
    EXPECT_EQ(markers[0].variant, static_cast<Variant>(newer));
    EXPECT_EQ(VariantName(markers[0].variant), "unknown");
    EXPECT_EQ(VariantName(markers[1].variant), VariantName(SamplePoses(2).markers[1].variant));
    // Passed on, it is the same again.
    EXPECT_EQ(Encoded(std::get<PosesMessage>(*message))[variant], newer);
  }
}

TEST(Wire, CarriesStatesAndInstantsThatItDoesNotKnow) {
  StatusMessage status = SampleStatus();
  status.camera_state = static_cast<CameraState>(9);
  status.publisher.state = static_cast<PublisherState>(9);
  const auto received = DecodeMessage(Encoded(status));
  ASSERT_TRUE(received.has_value());
  EXPECT_EQ(std::get<StatusMessage>(*received).camera_state, status.camera_state);
  EXPECT_EQ(std::get<StatusMessage>(*received).publisher.state, status.publisher.state);
  PosesMessage poses = SamplePoses(1);
  poses.instant = static_cast<ExposureInstant>(9);
  const auto frame = DecodeMessage(Encoded(poses));
  ASSERT_TRUE(frame.has_value());
  EXPECT_EQ(std::get<PosesMessage>(*frame).instant, poses.instant);
}

TEST(Wire, RefusesSizesThatDoNotExist) {
  const std::vector<std::uint8_t> bytes = Encoded(SamplePoses(1));
  const std::size_t marker = bytes.size() - 187;
  for (const std::size_t field : {10u, 11u}) {  // rows, cols
    std::vector<std::uint8_t> wrong = bytes;
    wrong[marker + field] = 120;
    EXPECT_FALSE(DecodeMessage(wrong).has_value()) << field;
    wrong[marker + field] = 0xff;
    EXPECT_FALSE(DecodeMessage(wrong).has_value()) << field;
  }
}

TEST(Wire, RefusesANegativeCountOfMarkers) {
  std::vector<std::uint8_t> bytes = Encoded(SamplePoses(1));
  bytes[bytes.size() - 187 - 4] = 0xff;
  EXPECT_FALSE(DecodeMessage(bytes).has_value());
}

TEST(Wire, RefusesTextsWithZeroBytes) {
  StatusMessage status = SampleStatus();
  status.drops = {{"name_of_a_drop", 1}};
  std::vector<std::uint8_t> bytes = Encoded(status);
  const std::string name = "name_of_a_drop";
  const auto place = std::search(bytes.begin(), bytes.end(), name.begin(), name.end());
  ASSERT_NE(place, bytes.end());
  EXPECT_TRUE(DecodeMessage(bytes).has_value());
  *(place + 3) = 0;
  EXPECT_FALSE(DecodeMessage(bytes).has_value());
}

TEST(Wire, RefusesNamesOfRobotsWithZeroBytes) {
  const std::string name = "robot 0";
  for (std::vector<std::uint8_t> bytes : {Encoded(SampleRobots(1)), Encoded(SampleTracks(1))}) {
    const auto place = std::search(bytes.begin(), bytes.end(), name.begin(), name.end());
    ASSERT_NE(place, bytes.end());
    EXPECT_TRUE(DecodeMessage(bytes).has_value());
    *(place + 3) = 0;
    EXPECT_FALSE(DecodeMessage(bytes).has_value());
  }
}

/// The most memory this process ever had, kB.
long PeakMemory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

// Found by fuzzing: LCM's own decoders make room for what a message says before they look for it.
TEST(Wire, MakesNoRoomForMarkersThatTheMessageHasNoBytesFor) {
  std::vector<std::uint8_t> bytes = Encoded(SamplePoses(1));
  bytes[bytes.size() - 187 - 3] = 0x10;  // a million markers, some 300 MB of them
  const long before = PeakMemory();
  EXPECT_FALSE(DecodeMessage(bytes).has_value());
  EXPECT_LT(PeakMemory() - before, 100'000);
}

}  // namespace
}  // namespace chequer
