// What the detector still reads: conditions of the simulator, of each so many frames with seeds of their own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <initializer_list>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "simulate/layouts.h"
#include "simulate/render.h"
#include "support/stress_frames.h"

namespace chequer {
namespace {

using test::CaseOf;
using test::Look;

struct Limit {
  const char* tag;  ///< of a stress case
  int frames;
  int least;  ///< of them read
};

void PrintTo(const Limit& limit, std::ostream* out) { *out << limit.tag; }

class Limits : public testing::TestWithParam<Limit> {};

/// Of boards seen at 75 degrees, one a seed, how many are read. @param first added to a seed for the scene's.
int ReadOfSteep(std::initializer_list<std::uint64_t> seeds, std::uint64_t first = 0) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  int read = 0;
  for (const std::uint64_t seed : seeds) {
    const StressCase stress = CaseOf("tilt_deg=75", code, first + seed);
    for (const MarkerPose& marker : Look(stress, code, seed)) {
      if (!marker.id) continue;
      EXPECT_EQ(*marker.id, stress.scene.markers[0].board.id) << "wrong id, seed " << seed;
      ++read;
    }
  }
  return read;
}

/// How many frames of one board are read.
struct Tally {
  int read = 0;
  std::string missed;  ///< seeds

  /// Expects the board's id, and the board but once.
  void Add(const StressCase& stress, const MarkerCode& code, std::uint64_t seed) {
    const std::uint64_t id = stress.scene.markers[0].board.id;
    bool found = false;
    const std::vector<MarkerPose> markers = Look(stress, code, seed);
    EXPECT_LE(markers.size(), 1u) << "one board twice, seed " << seed;
    for (const MarkerPose& marker : markers) {
      if (!marker.id) continue;
      EXPECT_EQ(*marker.id, id) << "wrong id, seed " << seed;
      found |= *marker.id == id;
    }
    read += found;
    if (!found) missed += " " + std::to_string(seed);
  }
};

TEST_P(Limits, AreReached) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  Tally tally;
  for (int frame = 0; frame < GetParam().frames; ++frame) {
    const std::uint64_t seed = 7000 + static_cast<std::uint64_t>(frame);
    tally.Add(CaseOf(GetParam().tag, code, seed), code, seed);
  }
  EXPECT_GE(tally.read, GetParam().least) << "of " << GetParam().frames << "; seeds missed:" << tally.missed;
}

TEST(MotionBlurredBoards, AreNotReadWrongly) {
  // Their darkest levels come out below zero: what black cells have in common there is no ink, and tells nothing.
  const MarkerCode code({6, 6}, Variant::kSecded);
  for (const auto& [tag, seed, bayer] :
       {std::tuple{"motion_px=12", 20107u, false}, std::tuple{"motion_px=8", 9003u, true}}) {
    StressCase stress = CaseOf(tag, code, seed);
    if (bayer) stress.options.format = PixelFormat::kBayerRg8;
    const std::vector<MarkerPose> markers = Look(stress, code, seed);
    ASSERT_EQ(markers.size(), 1u) << tag;
    if (markers[0].id) {
      EXPECT_EQ(*markers[0].id, stress.scene.markers[0].board.id) << tag;
    }
  }
}

/// Of a swarm's boards, how many are read in its image by `sensor`. Expects every id but once, and none that is not there.
int ReadOfSwarm(SwarmOptions swarm, int boards, const SensorOptions& sensor, double motion_px, std::uint64_t seed) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  constexpr std::uint64_t kFirstId = 100;
  for (int i = 0; i < boards; ++i) swarm.boards.push_back(MakeBoard(code, kFirstId + static_cast<std::uint64_t>(i)));
  Scene scene;
  scene.markers = Swarm(swarm, seed).At(std::chrono::seconds(1));
  scene.background = {.kind = BackgroundKind::kNoise, .seed = seed};
  RenderOptions options;
  options.camera = swarm.camera;
  options.sensor = sensor;
  options.motion_px = motion_px;
  options.motion_angle_rad = 0.5;
  DetectorOptions detector;
  detector.families = {{.code = code, .side_m = swarm.side_m, .roster = {}}};
  detector.camera = swarm.camera;
  std::vector<std::uint64_t> ids;
  for (const MarkerPose& marker : Detector(detector).Detect(Render(scene, options, seed).view()))
    if (marker.id) ids.push_back(*marker.id);
  std::sort(ids.begin(), ids.end());
  EXPECT_EQ(std::adjacent_find(ids.begin(), ids.end()), ids.end()) << "an id twice, seed " << seed;
  for (const std::uint64_t id : ids)
    EXPECT_TRUE(id >= kFirstId && id < kFirstId + static_cast<std::uint64_t>(boards)) << "no such id, seed " << seed;
  return static_cast<int>(ids.size());
}

TEST(Swarm, IsReadInDimLight) {
  // A dozen boards have more corners than are taken for a lot to look at; their weaker ones are no clutter.
  SwarmOptions swarm;
  swarm.camera = {.width = 640, .height = 480, .fx = 600, .fy = 600, .cx = 320, .cy = 240};
  swarm.distance_m = 1.5;
  SensorOptions sensor;
  sensor.exposure = 0.03;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) EXPECT_EQ(ReadOfSwarm(swarm, 12, sensor, 0, seed), 12) << "seed " << seed;
}

TEST(Swarm, IsReadWhereAKnockBlursAllOfIt) {
  // By more than a cell: the first pass over the image shows half of the boards, each other one needs a view of its own.
  SwarmOptions swarm;
  swarm.camera = {.width = 1280, .height = 720, .fx = 1800, .fy = 1800, .cx = 640, .cy = 360};
  swarm.distance_m = 3;
  swarm.side_m = 0.1;
  int read = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) read += ReadOfSwarm(swarm, 16, {}, 12, seed);
  EXPECT_GE(read, 38) << "of 48 boards";
}

TEST(TwoBoards, AreReadFromTheSide) {
  // What another board of the image has told lets a board's first step trust levels that were sampled: not where cells
  // are narrow one way, as in these frames.
  const MarkerCode code({6, 6}, Variant::kSecded);
  for (const auto& [tag, seed] : {std::pair{"tilt_deg=70", 11u}, std::pair{"tilt_deg=75", 9u}}) {
    StressCase stress = CaseOf(tag, code, 1000 + seed);
    SceneMarker& one = stress.scene.markers[0];
    SceneMarker other = one;
    one.camera_from_marker.translation.x() -= 0.66 * one.side_m;
    other.camera_from_marker.translation.x() += 0.66 * one.side_m;
    stress.scene.markers.push_back(other);
    EXPECT_EQ(Look(stress, code, seed).size(), 2u) << tag;
  }
}

TEST(SecondLook, ReportsNoMarkerTwice) {
  // In frame 7027, points along the rim of the marker that was read make a place of their own, which shows it again.
  const MarkerCode code({6, 6}, Variant::kSecded);
  for (std::uint64_t seed = 7020; seed < 7030; ++seed)
    EXPECT_EQ(Look(CaseOf("haze=0.25", code, seed), code, seed).size(), 1u) << "seed " << seed;
}

TEST(SecondLook, ReplacesWhatTheFirstHasSeenBadly) {
  // In frame 86, few corners of the first look make a board that is placed wrong; the second look sees all 25.
  const MarkerCode code({6, 6}, Variant::kSecded);
  const StressCase stress = CaseOf("tilt_deg=70", code, 86);
  const std::vector<MarkerPose> markers = Look(stress, code, 86);
  ASSERT_EQ(markers.size(), 1u);
  EXPECT_EQ(markers[0].id, stress.scene.markers[0].board.id);
  EXPECT_EQ(markers[0].corners_used, 25);
}

TEST(SecondLook, TellsABoardFromTheClutterAroundIt) {
  // Black letters all around hide how the corners of the board spread, were it not for its colours: without them, none
  // of these frames is read.
  const MarkerCode code({6, 6}, Variant::kSecded);
  Tally tally;
  for (const std::uint64_t seed :
       {7006u, 7007u, 7011u, 7033u, 7050u, 7062u, 7074u, 7075u, 7103u, 7129u, 7130u, 7142u, 7145u, 7146u, 7150u}) {
    StressCase stress = CaseOf("tilt_deg=75", code, seed);
    stress.scene.background.kind = BackgroundKind::kText;
    tally.Add(stress, code, seed);
  }
  // So steep, some may be lost by rounding alone.
  EXPECT_GE(tally.read, 6) << "seeds missed:" << tally.missed;
}

TEST(FewCorners, LeadToTheOthers) {
  // Of these boards few corners hang together, all on one side: the others lie up to 20 px from where those have them.
  // By the pixels of the found ones first, all of them are read; without, none.
  // So steep, one may be lost by rounding alone.
  EXPECT_GE(ReadOfSteep({5014, 5015, 5031, 5050}), 3);
}

TEST(FewPoints, StillLeadToABoard) {
  // Of these boards the first look finds at most 3 corners, and the strong contrasts spread as they like: what changes
  // from pixel to pixel tells where they lie. By points alone, none of them is read.
  // So steep, some may be lost by rounding alone.
  EXPECT_GE(ReadOfSteep({26, 61, 103, 211, 5100, 5115}), 4);
}

TEST(Covered, TheSideIsThatWhichDoesNotShow) {
  // Strips along one side, most of a line of cells: what is left of the border matches as if another side were covered,
  // and with both of them, next to nothing of the board is left.
  const MarkerCode code({6, 6}, Variant::kSecded);
  for (const std::uint64_t seed : {603u, 1088u, 1097u, 1226u, 1393u}) {
    const StressCase stress = CaseOf("occluded=0.1", code, seed);
    const std::vector<MarkerPose> markers = Look(stress, code, seed);
    ASSERT_EQ(markers.size(), 1u) << "seed " << seed;
    EXPECT_EQ(markers[0].id, stress.scene.markers[0].board.id) << "seed " << seed;
    EXPECT_GE(markers[0].corners_used, 20) << "seed " << seed;
  }
}

std::string NameOf(const testing::TestParamInfo<Limit>& limit) {
  std::string name = limit.param.tag;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Stress, Limits,
                         testing::Values(Limit{"tilt_deg=55", 20, 20}, Limit{"tilt_deg=65", 20, 20},
                                         Limit{"tilt_deg=70", 20, 20}, Limit{"tilt_deg=75", 20, 18},
                                         Limit{"tilt_deg=80", 20, 10}, Limit{"side_px=21", 60, 56},
                                         Limit{"motion_px=12", 20, 12}, Limit{"occluded=0.1", 20, 20},
                                         Limit{"occluded=0.2", 20, 19}, Limit{"ink_spread=0.2", 20, 17}),
                         NameOf);

}  // namespace
}  // namespace chequer
