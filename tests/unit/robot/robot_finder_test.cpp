#include "robot/robot_finder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/dense.h"
#include "support/error_of.h"
#include "support/seed.h"
#include "unit/robot/measured_boards.h"

namespace chequer {
namespace {

using test::Detect;
using test::OnFloor;
using test::WorldFromCamera;
using ::testing::HasSubstr;

const MarkerFamily kFamily{.code = MarkerCode({6, 6}, Variant::kSecded), .side_m = 0.12, .roster = {}};

RobotFinder Finder(const std::string& roster, bool floor_mode = true, bool world = true) {
  RobotFinderOptions options{.roster = ParseRobotRoster(roster, "roster.toml", std::span(&kFamily, 1)),
                             .world_from_camera = std::nullopt,
                             .floor_mode = floor_mode};
  if (world) options.world_from_camera = WorldFromCamera();
  return RobotFinder(std::move(options));
}

std::vector<RobotPose> FindIn(const RobotFinder& finder, const std::vector<MarkerPose>& markers) {
  std::vector<RobotPose> robots;
  finder.Find(markers, robots);
  return robots;
}

/// What the camera sees of a robot's marker.
MarkerPose SeeIn(const RobotFinder& finder, std::size_t robot, std::size_t marker,
                 const RigidTransform& world_from_body, std::mt19937_64* random = nullptr) {
  const RosterMarker& mounted = finder.options().roster.robots.at(robot).markers.at(marker);
  return Detect(mounted.id, WorldFromCamera().Inverse() * world_from_body * mounted.body_from_marker, random);
}

constexpr const char* kAliceAndBob = R"(
[[robot]]
name = "alice"
id = 3
height = 0.1
position = [0.05, 0, 0.08]
heading = 90
[[robot]]
name = "bob"
[[robot.marker]]
id = 10
position = [0.1, 0, 0.2]
[[robot.marker]]
id = 11
position = [-0.1, 0, 0.2]
heading = 180
)";

/// Of the roster of Alice and Bob, in floor mode.
class RobotFinderTest : public ::testing::Test {
 protected:
  std::vector<RobotPose> Find(const std::vector<MarkerPose>& markers) const { return FindIn(finder_, markers); }
  MarkerPose See(std::size_t robot, std::size_t marker, const RigidTransform& world_from_body,
                 std::mt19937_64* random = nullptr) const {
    return SeeIn(finder_, robot, marker, world_from_body, random);
  }

  const RobotFinder finder_ = Finder(kAliceAndBob);
};

TEST_F(RobotFinderTest, GivesTheBodyInTheWorldNotTheMarkerInTheCamera) {
  const RigidTransform truth = OnFloor(0.3, -0.2, 0.7, 0.02);  // its origin is 2 cm over the floor
  const auto robots = Find({See(0, 0, truth)});
  ASSERT_EQ(robots.size(), 1u);
  EXPECT_EQ(robots[0].name, "alice");
  EXPECT_EQ(robots[0].marker_count, 1);
  EXPECT_EQ(robots[0].ids[0], 3u);
  EXPECT_LT((robots[0].frame_from_body.translation - truth.translation).norm(), 1e-5);
  EXPECT_NEAR(HeadingRad(robots[0].frame_from_body.rotation), 0.7, 1e-5);
  ASSERT_TRUE(robots[0].floor.has_value());
  EXPECT_LT((robots[0].floor->position - Eigen::Vector2d(0.3, -0.2)).norm(), 1e-6);
  EXPECT_NEAR(robots[0].floor->heading_rad, 0.7, 1e-6);
  EXPECT_NEAR(robots[0].floor->height_m, 0.02, 1e-12);
  EXPECT_NEAR(robots[0].floor->height_error_m, 0, 1e-5);
  EXPECT_NEAR(robots[0].floor->tilt_rad, 0, 1e-4);
  EXPECT_FALSE(robots[0].floor->off_floor);
}

TEST_F(RobotFinderTest, ItsCovarianceIsOfTheBodyInTheWorld) {
  std::mt19937_64 random = test::SeededGenerator();
  const RigidTransform truth = {RotationFromVector({0.3, 0.1, 0.7}), {0.3, -0.2, 0.4}};
  double sum = 0;
  constexpr int kRuns = 300;
  for (int i = 0; i < kRuns; ++i) {
    const auto robots = Find({See(0, 0, truth, &random)});
    ASSERT_EQ(robots.size(), 1u);
    Eigen::Matrix<double, 6, 1> error;
    error << robots[0].frame_from_body.translation - truth.translation,
        VectorFromRotation(robots[0].frame_from_body.rotation * truth.rotation.conjugate());
    sum += test::SquareOver(error, robots[0].covariance) / 6;
  }
  EXPECT_NEAR(sum / kRuns, 1, 0.2);
}

TEST_F(RobotFinderTest, WithoutAWorldRobotsAreInTheCamerasFrame) {
  const RobotFinder finder = Finder(kAliceAndBob, false, false);
  const RigidTransform truth = OnFloor(0.3, -0.2, 0.7);
  const auto robots = FindIn(finder, {SeeIn(finder, 0, 0, truth)});
  ASSERT_EQ(robots.size(), 1u);
  const RigidTransform camera_from_body = WorldFromCamera().Inverse() * truth;
  EXPECT_LT((robots[0].frame_from_body.translation - camera_from_body.translation).norm(), 1e-5);
  EXPECT_FALSE(robots[0].floor.has_value());
}

TEST_F(RobotFinderTest, SeesThatARobotFell) {
  std::mt19937_64 random = test::SeededGenerator();
  const RigidTransform leaning = {RotationFromVector({0.6, 0, 0}), {0.1, 0.2, 0.05}};
  const RigidTransform lifted = OnFloor(0.1, 0.2, 1, 0.3);
  const RigidTransform upright = OnFloor(0.1, 0.2, 1, 0.02);
  const auto off_floor = [&](const RigidTransform& world_from_body) {
    const auto robots = Find({See(0, 0, world_from_body, &random)});
    return robots.at(0).floor.value();
  };
  const FloorPose fallen = off_floor(leaning);
  EXPECT_TRUE(fallen.off_floor);
  EXPECT_NEAR(fallen.tilt_rad, 0.6, 0.02);
  EXPECT_GT(fallen.chi_square, 50);
  const FloorPose raised = off_floor(lifted);
  EXPECT_TRUE(raised.off_floor);
  EXPECT_NEAR(raised.height_error_m, 0.28, 0.01);
  double chi_square = 0;
  for (int i = 0; i < 100; ++i) {
    const FloorPose standing = off_floor(upright);
    EXPECT_FALSE(standing.off_floor) << i;
    chi_square += standing.chi_square;
  }
  EXPECT_NEAR(chi_square / 100, 3, 1);
}

TEST_F(RobotFinderTest, EstimatesARobotFromBothItsMarkersOrFromEither) {
  const RigidTransform truth = OnFloor(-0.2, 0.1, -2);
  const MarkerPose front = See(1, 0, truth), back = See(1, 1, truth);
  const auto both = Find({back, front});
  ASSERT_EQ(both.size(), 1u);
  EXPECT_EQ(both[0].marker_count, 2);
  EXPECT_EQ(both[0].ids[0], 10u);
  EXPECT_EQ(both[0].ids[1], 11u);
  for (const auto& robots : {both, Find({front}), Find({back})}) {
    ASSERT_EQ(robots.size(), 1u);
    EXPECT_EQ(robots[0].name, "bob");
    EXPECT_LT((robots[0].frame_from_body.translation - truth.translation).norm(), 1e-5);
    EXPECT_NEAR(robots[0].floor->heading_rad, -2, 1e-6);
  }
  const auto alone = Find({front});
  EXPECT_EQ(alone[0].marker_count, 1);
  EXPECT_LT(both[0].covariance(5, 5), 0.5 * alone[0].covariance(5, 5)) << "two markers tell the heading better";
}

TEST_F(RobotFinderTest, UsesOneMarkerWhereTheOtherDoesNotFitTheBody) {
  const RigidTransform truth = OnFloor(0, 0, 0);
  const MarkerPose front = See(1, 0, truth), strayed = See(1, 1, OnFloor(0.5, 0.5, 1));
  const auto robots = Find({front, strayed});
  ASSERT_EQ(robots.size(), 1u);
  EXPECT_EQ(robots[0].marker_count, 1);
}

constexpr const char* kSharedIds = R"(
[[robot]]
name = "ab"
[[robot.marker]]
id = 1
position = [0.1, 0, 0.2]
[[robot.marker]]
id = 2
position = [-0.1, 0, 0.2]
[[robot]]
name = "ac"
[[robot.marker]]
id = 1
position = [0.1, 0, 0.2]
[[robot.marker]]
id = 3
position = [-0.1, 0, 0.2]
)";

TEST_F(RobotFinderTest, TellsRobotsThatShareAnIdByTheirPairs) {
  const RobotFinder finder = Finder(kSharedIds);
  const RigidTransform ab = OnFloor(0.4, 0, 0.5), ac = OnFloor(-0.4, 0.1, 2);
  const auto robots = FindIn(
      finder, {SeeIn(finder, 1, 0, ac), SeeIn(finder, 0, 1, ab), SeeIn(finder, 0, 0, ab), SeeIn(finder, 1, 1, ac)});
  ASSERT_EQ(robots.size(), 2u);
  EXPECT_EQ(robots[0].name, "ab");
  EXPECT_LT((robots[0].frame_from_body.translation - ab.translation).norm(), 1e-5);
  EXPECT_EQ(robots[1].name, "ac");
  EXPECT_LT((robots[1].frame_from_body.translation - ac.translation).norm(), 1e-5);
  EXPECT_TRUE(FindIn(finder, {SeeIn(finder, 0, 0, ab)}).empty()) << "id 1 alone may be either";
  EXPECT_EQ(FindIn(finder, {SeeIn(finder, 0, 1, ab)}).at(0).name, "ab") << "id 2 is of one alone";
}

TEST_F(RobotFinderTest, PassesOverWhatIsNoRobotsMarker) {
  MarkerPose undecided = See(0, 0, OnFloor(0, 0, 0));
  undecided.id.reset();
  MarkerPose without_pose = See(0, 0, OnFloor(0, 0, 0));
  without_pose.has_pose = false;
  MarkerPose other_family = See(0, 0, OnFloor(0, 0, 0));
  other_family.family = 1;
  const MarkerPose stranger = Detect(99, WorldFromCamera().Inverse() * OnFloor(0, 0, 0));
  EXPECT_TRUE(Find({undecided, without_pose, other_family, stranger}).empty());
  EXPECT_FALSE(finder_.Knows(undecided));
  EXPECT_FALSE(finder_.Knows(other_family));
  EXPECT_FALSE(finder_.Knows(stranger));
  EXPECT_TRUE(finder_.Knows(without_pose));
}

TEST_F(RobotFinderTest, GivesARobotTwiceWhoseMarkerIsSeenTwice) {
  const auto robots = Find({See(0, 0, OnFloor(0, 0, 0)), See(0, 0, OnFloor(0.5, 0, 0))});
  EXPECT_EQ(robots.size(), 2u);
}

TEST_F(RobotFinderTest, SaysWhatItNeeds) {
  EXPECT_THAT(test::ErrorOf([] { Finder(kAliceAndBob, true, false); }), HasSubstr("needs a world"));
}

}  // namespace
}  // namespace chequer
