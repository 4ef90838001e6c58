#include "tools/id_filter.h"

#include <gtest/gtest.h>

#include "unit/publish/messages.h"

namespace chequer {
namespace {

TEST(IdFilter, LeavesWhatBearsAnId) {
  PosesMessage poses;
  for (const std::uint64_t id : {1u, 5u, 9u}) {
    MarkerPose marker;
    marker.id = id;
    poses.markers.push_back(marker);
  }
  poses.markers.emplace_back();  // without an id
  ReceivedMessage message = poses;
  IdFilter("0-5,77").Keep(message);
  const auto& left = std::get<PosesMessage>(message).markers;
  ASSERT_EQ(left.size(), 2u);
  EXPECT_EQ(left[1].id, 5u);
}

TEST(IdFilter, KnowsRobotsAndTracksByTheirMarkers) {
  RobotsMessage robots;
  RobotPose two;
  two.ids = {3, 40};
  two.marker_count = 2;
  RobotPose one;
  one.ids = {7, 40};  // the second is not in use
  one.marker_count = 1;
  robots.robots = {two, one};
  ReceivedMessage message = robots;
  IdFilter("40").Keep(message);
  EXPECT_EQ(std::get<RobotsMessage>(message).robots.size(), 1u);
  TracksMessage tracks;
  tracks.tracks.resize(2);
  tracks.tracks[1].key.id = 40;
  message = tracks;
  IdFilter("40").Keep(message);
  EXPECT_EQ(std::get<TracksMessage>(message).tracks.size(), 1u);
}

}  // namespace
}  // namespace chequer
