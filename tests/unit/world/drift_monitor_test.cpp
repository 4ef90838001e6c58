#include "world/drift_monitor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace chequer {
namespace {

using std::chrono::milliseconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr milliseconds kFrame{50};

/// A camera 2.5 m over the floor that looks down, tilted a little, and references about it.
WorldCalibration Room(int references) {
  WorldCalibration world;
  world.world_from_camera.translation = {1, 0.5, 2.5};
  world.world_from_camera.rotation = RotationFromVector({3.0, 0.1, 0});
  for (int i = 0; i < references; ++i) {
    WorldReference reference;
    reference.id = static_cast<std::uint64_t>(10 + i);
    reference.side_m = 0.12;
    reference.world_from_marker.translation = {0.4 * i, 0.3 * (i % 2), 0};
    reference.world_from_marker.rotation = RotationFromVector({0, 0, 0.3 * i});
    world.references.push_back(reference);
  }
  return world;
}

/// What a camera that now stands at `world_from_camera` sees of the references.
std::vector<MarkerPose> See(const WorldCalibration& world, const RigidTransform& world_from_camera) {
  std::vector<MarkerPose> markers;
  for (const WorldReference& reference : world.references) {
    MarkerPose marker;
    marker.id = reference.id;
    marker.has_pose = true;
    marker.camera_from_marker = world_from_camera.Inverse() * reference.world_from_marker;
    markers.push_back(marker);
  }
  return markers;
}

RigidTransform Knocked(const WorldCalibration& world, double angle_rad) {
  RigidTransform turn;
  turn.rotation = RotationFromVector({angle_rad, 0, 0});
  return world.world_from_camera * turn;
}

/// Feeds the same view for a while; what was said, in order.
class Feed {
 public:
  explicit Feed(DriftMonitor& monitor) : monitor_(monitor) {}
  std::vector<std::string> Frames(const std::vector<MarkerPose>& markers, int count) {
    std::vector<std::string> said;
    for (int i = 0; i < count; ++i)
      if (const auto message = monitor_.Take(markers, now_ += kFrame)) said.push_back(*message);
    return said;
  }

 private:
  DriftMonitor& monitor_;
  MonotonicTime now_{std::chrono::seconds(100)};
};

TEST(DriftMonitor, SaysNothingWhileAllStandsStill) {
  const WorldCalibration world = Room(4);
  DriftMonitor monitor(world);
  EXPECT_TRUE(Feed(monitor).Frames(See(world, world.world_from_camera), 200).empty());
  EXPECT_FALSE(monitor.has_drifted());
  for (const ReferenceDrift& drift : monitor.drifts()) {
    EXPECT_TRUE(drift.in_view);
    EXPECT_LT(drift.offset_m, 1e-9);
  }
}

TEST(DriftMonitor, WarnsOnceOfAKnockedCamera) {
  const WorldCalibration world = Room(4);
  DriftMonitor monitor(world);
  Feed feed(monitor);
  feed.Frames(See(world, world.world_from_camera), 20);
  // A quarter of a degree is 11 mm at 2.5 m.
  const auto said = feed.Frames(See(world, Knocked(world, 0.25 * M_PI / 180)), 200);
  // They cross the limit one after the other; the last word names them all.
  ASSERT_FALSE(said.empty());
  EXPECT_LE(said.size(), 4u);
  EXPECT_THAT(said.back(), AllOf(HasSubstr("10 by"), HasSubstr("13 by"), HasSubstr("the camera was moved"),
                                 HasSubstr("chequer calibrate world")));
  EXPECT_TRUE(monitor.has_drifted());
  EXPECT_NEAR(monitor.drifts()[0].offset_m, 2.5 * 0.25 * M_PI / 180, 0.004);
}

TEST(DriftMonitor, TellsAMovedReferenceFromAMovedCamera) {
  const WorldCalibration world = Room(4);
  WorldCalibration moved = world;
  moved.references[2].world_from_marker.translation.x() += 0.03;
  DriftMonitor monitor(world);
  const auto said = Feed(monitor).Frames(See(moved, world.world_from_camera), 200);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_THAT(said[0],
              AllOf(HasSubstr("12 by"), Not(HasSubstr("11 by")), HasSubstr("3 of 4 in view are where they were")));
}

TEST(DriftMonitor, NoticesATurnAboutTheLineOfSight) {
  const WorldCalibration world = Room(1);
  WorldCalibration turned = world;
  turned.references[0].world_from_marker.rotation = RotationFromVector({0, 0, 0.2});
  DriftMonitor monitor(world);
  const auto said = Feed(monitor).Frames(See(turned, world.world_from_camera), 200);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_THAT(said[0], HasSubstr("the only one in view"));
}

TEST(DriftMonitor, OneWildPoseWarnsOfNothing) {
  const WorldCalibration world = Room(2);
  DriftMonitor monitor(world);
  Feed feed(monitor);
  feed.Frames(See(world, world.world_from_camera), 20);
  EXPECT_TRUE(feed.Frames(See(world, Knocked(world, 1)), 1).empty());
  EXPECT_TRUE(feed.Frames(See(world, world.world_from_camera), 100).empty());
}

/// What the same camera sees where each pose is scaled, as by a wrong side.
std::vector<MarkerPose> SeeScaled(const WorldCalibration& world, double scale) {
  std::vector<MarkerPose> markers = See(world, world.world_from_camera);
  for (MarkerPose& marker : markers) marker.camera_from_marker.translation *= scale;
  return markers;
}

TEST(DriftMonitor, TellsAWrongSideFromAMovedCamera) {
  const WorldCalibration world = Room(4);
  for (const double scale : {0.10 / 0.12, 0.12 / 0.10, 0.95}) {
    DriftMonitor monitor(world);
    const auto said = Feed(monitor).Frames(SeeScaled(world, scale), 200);
    ASSERT_EQ(said.size(), 1u) << scale;
    EXPECT_THAT(said[0], AllOf(HasSubstr("side of the markers is wrong"), HasSubstr("nothing moved"),
                               Not(HasSubstr("camera was moved"))));
    EXPECT_TRUE(monitor.has_drifted());
  }
  DriftMonitor monitor(world);
  EXPECT_THAT(Feed(monitor).Frames(SeeScaled(world, 0.12 / 0.144), 200).at(0),
              HasSubstr("prints of 144 mm, not of 120"));
}

TEST(DriftMonitor, NamesTheSideAmongTheCausesWhereOneReferenceIsInView) {
  const WorldCalibration world = Room(1);
  DriftMonitor monitor(world);
  const auto said = Feed(monitor).Frames(SeeScaled(world, 0.8), 200);
  ASSERT_FALSE(said.empty());
  EXPECT_THAT(said.back(), AllOf(HasSubstr("the only one in view"), HasSubstr("looks 0.8 times as far away")));
}

TEST(DriftMonitor, TellsACameraThatWasRaisedFromAWrongSide) {
  const WorldCalibration world = Room(4);
  RigidTransform raised = world.world_from_camera;
  raised.translation.z() += 0.3;
  DriftMonitor monitor(world);
  const auto said = Feed(monitor).Frames(See(world, raised), 200);
  ASSERT_FALSE(said.empty());
  for (const std::string& text : said) EXPECT_THAT(text, Not(HasSubstr("side of the markers")));
  EXPECT_THAT(said.back(), HasSubstr("the camera was moved"));
}

TEST(DriftMonitor, SaysWhenTheSideIsRightAgain) {
  const WorldCalibration world = Room(3);
  DriftMonitor monitor(world);
  Feed feed(monitor);
  ASSERT_EQ(feed.Frames(SeeScaled(world, 0.9), 200).size(), 1u);
  const auto said = feed.Frames(See(world, world.world_from_camera), 400);
  ASSERT_FALSE(said.empty());
  EXPECT_THAT(said.back(), HasSubstr("are where they were"));
  EXPECT_FALSE(monitor.has_drifted());
}

TEST(DriftMonitor, SaysWhenAllIsBack) {
  const WorldCalibration world = Room(2);
  DriftMonitor monitor(world);
  Feed feed(monitor);
  feed.Frames(See(world, Knocked(world, 0.01)), 200);
  ASSERT_TRUE(monitor.has_drifted());
  const auto said = feed.Frames(See(world, world.world_from_camera), 400);
  ASSERT_FALSE(said.empty());
  EXPECT_THAT(said.back(), HasSubstr("are where they were"));
  EXPECT_FALSE(monitor.has_drifted());
}

TEST(DriftMonitor, PassesOverWhatIsNoReference) {
  const WorldCalibration world = Room(2);
  DriftMonitor monitor(world);
  std::vector<MarkerPose> markers = See(world, Knocked(world, 0.1));
  markers[0].id = 99;                    // another marker
  markers[1].variant = Variant::kTable;  // the same number of another kind
  EXPECT_TRUE(Feed(monitor).Frames(markers, 100).empty());
  markers = See(world, Knocked(world, 0.1));
  markers[0].id.reset();
  markers[1].has_pose = false;
  EXPECT_TRUE(Feed(monitor).Frames(markers, 100).empty());
  EXPECT_FALSE(monitor.drifts()[0].in_view);
}

TEST(DriftMonitor, RefusesALimitThatMeansNothing) {
  EXPECT_THROW(DriftMonitor(Room(1), {.limit_m = 0}), std::runtime_error);
  EXPECT_THROW(DriftMonitor(Room(1), {.window = milliseconds(0)}), std::runtime_error);
}

}  // namespace
}  // namespace chequer
