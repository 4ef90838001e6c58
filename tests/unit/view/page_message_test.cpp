#include "view/page_message.h"

#include <gtest/gtest.h>

#include <cmath>

#include "unit/publish/messages.h"
#include "unit/view/page.h"

namespace chequer {
namespace {

using test::At;

/// A marker straight in front of a camera of 500 px focal length, 2 m away: 0.2 m are 50 px.
struct View {
  PosesMessage message;
  CameraMessage camera;

  View() {
    camera.model = CameraModel{.width = 640,
                               .height = 480,
                               .fx = 500,
                               .fy = 500,
                               .cx = 320,
                               .cy = 240,
                               .kind = CameraModel::Kind::kPinhole,
                               .distortion = {}};
    camera.families = {{Variant::kSecded, {4, 8}, 0.2}};
    message.image_width = 640;
    message.image_height = 480;
    message.sequence = 77;
    message.captured_monotonic = MonotonicTime(std::chrono::milliseconds(1000));
    message.published_monotonic = MonotonicTime(std::chrono::microseconds(1'007'500));
    MarkerPose marker;
    marker.id = 0x1'0000'0005;
    marker.size = {4, 8};
    marker.has_pose = true;
    marker.warnings = 8;
    marker.corners_used = 20;
    marker.center_px = {320, 240};
    marker.camera_from_marker.translation = {0, 0, 2};
    marker.camera_from_marker.rotation = RotationFromVector({M_PI, 0, 0});  // it faces the camera
    marker.covariance(0, 0) = 1e-6;
    marker.covariance(1, 1) = 4e-6;
    message.markers.push_back(marker);
  }
};

float Word(const SharedPacket& packet, std::size_t word) { return At<float>(packet, kPageHeaderBytes + 4 * word); }

TEST(PageMessage, DrawsAMarkerWhereTheCameraSeesIt) {
  const View view;
  const SharedPacket packet = FramePacket(view.message, &view.camera, 3);
  ASSERT_EQ(packet->size(), kPageHeaderBytes + 4 * kMarkerWords);
  EXPECT_EQ(test::KindOf(packet), TopicKind::kFrame);
  EXPECT_EQ(At<std::uint16_t>(packet, 2), 3);
  EXPECT_EQ(At<std::uint32_t>(packet, 4), 1u);
  EXPECT_EQ(At<double>(packet, 8), 77);
  EXPECT_FLOAT_EQ(At<float>(packet, 48), 7.5F);
  EXPECT_EQ(At<std::uint32_t>(packet, 64), 5u);
  EXPECT_EQ(At<std::uint32_t>(packet, 68), 1u) << "the upper half of the id";
  EXPECT_EQ(At<std::uint32_t>(packet, 64 + 8) & 3u, 3u);
  EXPECT_EQ(At<std::uint32_t>(packet, 64 + 16), 4u | 8u << 8 | 20u << 16);
  // Eight columns over 0.2 m, four rows over 0.1 m; its y axis points up in the picture.
  const float outline[] = {295, 227.5, 345, 227.5, 345, 252.5, 295, 252.5};
  for (std::size_t i = 0; i < 8; ++i) EXPECT_NEAR(Word(packet, 8 + i), outline[i], 1e-3) << i;
  EXPECT_NEAR(Word(packet, 16), 345, 1e-3);
  EXPECT_NEAR(Word(packet, 19), 227.5, 1e-3);
  EXPECT_NEAR(Word(packet, 32), 0.5, 1e-3) << "2 mm at 2 m";
  EXPECT_NEAR(Word(packet, 33), 0.25, 1e-3);
  EXPECT_NEAR(Word(packet, 35), 2, 1e-6);
}

TEST(PageMessage, TurnsPosesInTheWorldIntoTheCameraAndBack) {
  View view;
  view.camera.world_from_camera = RigidTransform{RotationFromVector({M_PI, 0, 0}), {5, 6, 2}};
  const SharedPacket in_camera = FramePacket(view.message, &view.camera, 0);
  EXPECT_EQ(At<std::uint8_t>(in_camera, 1), 1) << "places are in the world where it is known";
  EXPECT_NEAR(Word(in_camera, 26), 5, 1e-6);
  EXPECT_NEAR(Word(in_camera, 28), 0, 1e-6) << "on the floor";
  MarkerPose& marker = view.message.markers[0];
  marker.camera_from_marker = *view.camera.world_from_camera * marker.camera_from_marker;
  view.message.frame = "world";
  const SharedPacket in_world = FramePacket(view.message, &view.camera, 0);
  for (std::size_t word = 8; word < 22; ++word) EXPECT_NEAR(Word(in_world, word), Word(in_camera, word), 1e-3) << word;
  EXPECT_NEAR(Word(in_world, 27), 6, 1e-6);
}

TEST(PageMessage, DrawsNoOutlineWhereItIsNotKnown) {
  View view;
  EXPECT_TRUE(std::isnan(Word(FramePacket(view.message, nullptr, 0), 8)));
  EXPECT_FALSE(std::isnan(Word(FramePacket(view.message, nullptr, 0), 6))) << "its middle is";
  view.message.markers[0].camera_from_marker.translation.z() = -1;
  EXPECT_TRUE(std::isnan(Word(FramePacket(view.message, &view.camera, 0), 8))) << "behind the camera";
  view.message.markers[0].family = 1;
  EXPECT_TRUE(std::isnan(Word(FramePacket(view.message, &view.camera, 0), 8))) << "of a family that is not there";
  view.message.markers[0].has_pose = false;
  EXPECT_TRUE(std::isnan(Word(FramePacket(view.message, &view.camera, 0), 26)));
}

TEST(PageMessage, NamesTracksAndRobots) {
  const TracksMessage tracks = test::SampleTracks(2);
  const SharedPacket packet = TracksPacket(tracks, 1);
  const auto names_at = At<std::uint32_t>(packet, 56);
  EXPECT_EQ(names_at, kPageHeaderBytes + 2 * 4 * kBodyWords);
  const auto names = nlohmann::json::parse(packet->data() + names_at, packet->data() + packet->size());
  ASSERT_EQ(names.size(), 2u);
  EXPECT_EQ(names[1], tracks.tracks[1].key.robot);
  EXPECT_FLOAT_EQ(Word(packet, kBodyWords + 4), static_cast<float>(tracks.tracks[1].frame_from_body.translation.x()));
  EXPECT_FLOAT_EQ(Word(packet, 8), static_cast<float>(tracks.tracks[0].velocity.x()));
  RobotsMessage robots = test::SampleRobots(1);
  robots.robots[0].name = "\xff\xfe";  // whatever the network brings
  EXPECT_GT(RobotsPacket(robots, 0)->size(), kPageHeaderBytes);
}

TEST(PageMessage, APictureBringsTheMarkersOfItsFrame) {
  const View view;
  const SharedPacket frame = FramePacket(view.message, &view.camera, 2);
  const PreviewMessage preview{.captured_utc = {},
                               .sequence = 77,
                               .camera = "c",
                               .asker = 0,
                               .image_width = 640,
                               .image_height = 480,
                               .region = {1, 2, 3, 4},
                               .width = 9,
                               .height = 8,
                               .jpeg = {0xff, 0xd8}};
  const SharedPacket packet = PicturePacket(TopicKind::kZoom, preview, frame, 2);
  EXPECT_EQ(packet->size(), kPageHeaderBytes + frame->size() + 2);
  EXPECT_EQ(At<std::uint32_t>(packet, 4), frame->size());
  EXPECT_EQ(At<std::uint16_t>(packet, 32), 1);
  EXPECT_EQ(At<std::uint16_t>(packet, 38), 4);
  EXPECT_EQ(std::memcmp(packet->data() + kPageHeaderBytes, frame->data(), frame->size()), 0);
  EXPECT_EQ(packet->data()[packet->size() - 2], 0xff);
  EXPECT_EQ(At<std::uint32_t>(PicturePacket(TopicKind::kPicture, preview, nullptr, 2), 4), 0u);
}

}  // namespace
}  // namespace chequer
