// What the last frames of a stream teach the next one.
#include "detect/memory/memory.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "chequer/detector.h"
#include "core/crop.h"
#include "detect/common/search_regions.h"
#include "support/pose_errors.h"
#include "support/same_bits.h"
#include "support/scenes.h"
#include "support/stream_frames.h"

namespace chequer {
namespace {

using namespace std::chrono_literals;
using test::Detected;
using test::DifferenceOf;

constexpr auto kInterval = 16667us;
const MarkerCode kCode({6, 6}, Variant::kSecded);

/// Passes frames through a detector with a memory.
class Follower {
 public:
  explicit Follower(const DetectorOptions& options) : detector_(options) {}

  const Detected& Next(const ImageView& image, std::chrono::microseconds after = kInterval) {
    now_ += after;
    detector_.Detect(image, now_, memory_, last_.markers);
    last_.stats = detector_.stats();
    return last_;
  }
  const DetectorMemory& memory() const { return memory_; }
  DetectorMemory& memory() { return memory_; }
  Detector& detector() { return detector_; }

 private:
  Detector detector_;
  DetectorMemory memory_;
  std::chrono::nanoseconds now_{1s};
  Detected last_;
};

DetectorOptions OptionsFor(const test::KnownFrame& frame) {
  DetectorOptions options;
  options.families = {{.code = kCode, .side_m = 0.12, .roster = {}}};
  options.camera = frame.options.camera;
  return options;
}

std::vector<std::uint64_t> IdsOf(const Detected& detected) {
  std::vector<std::uint64_t> ids;
  for (const MarkerPose& marker : detected.markers)
    if (marker.id) ids.push_back(*marker.id);
  return ids;
}

using Ids = std::vector<std::uint64_t>;

test::KnownFrame WithMarker(std::uint64_t id) { return test::OneMarker(kCode, id, 10, 3); }

test::KnownFrame Empty() {
  test::KnownFrame frame = WithMarker(1);
  frame.scene.markers.clear();
  return frame;
}

constexpr const char* kDriving = R"(
seed = 5
[camera]
size = "640x480"
focal_px = 800
distance = 2.0
fps = 60
exposure_ms = 1
[swarm]
robots = 5
side = 0.1
speed = 0.4
[[phase]]
kind = "calm"
frames = 10
)";

TEST(Predict, GoesOnAndTurnsAsBefore) {
  const auto pose = [](double angle, double x) {
    Eigen::Matrix3d plane_from_board = Eigen::Matrix3d::Identity();
    plane_from_board.topLeftCorner<2, 2>() = 9 * Eigen::Rotation2Dd(angle).toRotationMatrix();
    plane_from_board(0, 2) = x;
    return plane_from_board;
  };
  RememberedBoard board;
  board.plane_from_board = pose(0.1, 103);
  EXPECT_EQ(board.Ahead(0.02), board.plane_from_board) << "nothing is known of its motion";
  board.motion.before = pose(0, 100);
  board.motion.before_s = 0.02;
  EXPECT_LT((board.Ahead(0.02) - pose(0.2, 106)).norm(), 1e-9);
  EXPECT_LT((board.Ahead(0.01) - pose(0.15, 104.5)).norm(), 0.01) << "exact to the cube of the turn";
  EXPECT_NEAR(board.Ahead(0.02)(0, 2), 106, 1e-9);
  EXPECT_NEAR(board.Ahead(0.01)(0, 2), 104.5, 1e-9);
  board.motion.drift = {1, 0};
  board.motion.off = {1, 1, 0};
  EXPECT_NEAR(board.Ahead(0.02)(0, 2), 107, 1e-9) << "it gains speed";
  EXPECT_NEAR(TurnBetween(board.motion.before, board.plane_from_board), 0.1, 1e-9);
  board.motion.spin = -0.03;
  board.motion.turned_off = {1, 0};
  EXPECT_NEAR(TurnBetween(board.plane_from_board, board.Ahead(0.02)), 0.07, 1e-9) << "it turns ever slower";
}

/// A board at `time` frames after a start, in pixels of a camera that looks straight down: @param path tells its place
/// and heading.
template <class Path>
Eigen::Matrix3d LaidAt(const Path& path, double time) {
  const Eigen::Vector3d at = path(time);
  Eigen::Matrix3d plane_from_board = Eigen::Matrix3d::Identity();
  plane_from_board.topLeftCorner<2, 2>() = 9 * Eigen::Rotation2Dd(at.z()).toRotationMatrix();
  plane_from_board.topRightCorner<2, 1>() = at.head<2>();
  return plane_from_board;
}

/// How far off a board is expected that was followed along a path for eight frames, px; its turn.
template <class Path>
Eigen::Vector2d OffAfterEight(const Path& path) {
  constexpr double kFrameS = 0.02;
  RememberedBoard board;
  board.plane_from_board = LaidAt(path, 0);
  for (int frame = 1; frame <= 8; ++frame) {
    const RememberedBoard last = board;
    const Eigen::Matrix3d found = LaidAt(path, frame);
    board = {};
    board.motion.Learn(last.motion, last.plane_from_board, kFrameS, found);
    board.Move(&last, last.plane_from_board, found, kFrameS);
  }
  const Eigen::Matrix3d expected = board.Ahead(kFrameS), there = LaidAt(path, 9);
  return {(expected - there).col(2).norm(), TurnBetween(there, expected)};
}

TEST(BoardMotion, GoesOnInTheWayThatLedLeastFarOff) {
  const auto on_wheels = [](double t) {
    return Eigen::Vector3d(40 * std::sin(0.2 * t), -40 * std::cos(0.2 * t), 0.2 * t);
  };
  EXPECT_LT(OffAfterEight(on_wheels)[0], 1e-6) << "a turning robot's way turns with it";
  const auto gains_speed = [](double t) { return Eigen::Vector3d(3 * t + 0.4 * t * t, -t, 0.05 * t * t); };
  EXPECT_LT(OffAfterEight(gains_speed)[0], 1e-6);
  EXPECT_NEAR(OffAfterEight(gains_speed)[1], 0, 1e-6) << "it turns ever faster";
  const auto slides = [](double t) { return Eigen::Vector3d(5 * t, 2 * t, 0.2 * t); };
  EXPECT_LT(OffAfterEight(slides)[0], 1e-6) << "what turns on its way keeps it";
  // What a pose is off shows in the predictions: of one that stands, the fewest differences show least of it.
  const auto trembles = [](double t) { return Eigen::Vector3d(std::fmod(t, 2) < 1 ? 0.01 : -0.01, 0, 0); };
  EXPECT_LT(OffAfterEight(trembles)[0], 0.05);
}

TEST(SearchRegions, MakesOneOfThoseThatOverlap) {
  SearchRegions regions;
  regions.Start(1000, 1000);
  const auto box = [](float left, float top, float right, float bottom) {
    PixelBox made;
    made.Add(left, top);
    made.Add(right, bottom);
    return made;
  };
  regions.Add(box(10, 10, 50, 50));
  regions.Add(box(200, 200, 250, 250));
  regions.Add(box(40, 40, 80, 80));
  regions.Add(box(-30, 990, 5, 1200));
  regions.Merge();
  ASSERT_EQ(regions.regions().size(), 3u);
  EXPECT_EQ(regions.regions()[0].width, 71);
  EXPECT_FALSE(regions.is_all());
  regions.Add(box(0, 0, 800, 800));
  regions.Merge();
  EXPECT_TRUE(regions.is_all()) << "half of the image";
}

TEST(KnownTiles, CoverTheInsideOfOutlines) {
  KnownTiles known;
  known.Start(400, 300);
  EXPECT_FALSE(known.Covers({100, 100}));
  known.Add({Eigen::Vector2d(100, 60), {140, 100}, {100, 140}, {60, 100}});
  EXPECT_TRUE(known.Covers({100, 100}));
  EXPECT_TRUE(known.Covers({125, 100}));
  EXPECT_FALSE(known.Covers({135, 70}));
  EXPECT_FALSE(known.Covers({-5, 1000}));
}

TEST(Memory, FollowsBoardsWithoutASearch) {
  const test::StreamFrames stream{std::string_view(kDriving)};
  const DetectorOptions options = stream.Options();
  Follower follower(options);
  Detector cold(options);
  test::StreamScore score;
  test::PoseErrors differences;
  int mostly_unsearched = 0;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const test::StreamFrame frame = stream.Frame(i);
    const Detected& found = follower.Next(frame.image.view());
    score += test::ScoreFrame(found.markers, frame.truth);
    const std::int64_t all = std::int64_t{frame.image.width()} * frame.image.height();
    mostly_unsearched += found.stats.searched_px < all * 4 / 10;
    differences.AddDifferences(cold.Detect(frame.image.view()), found.markers);
  }
  EXPECT_EQ(score.read, score.expected);
  EXPECT_EQ(score.wrong + score.twice, 0);
  EXPECT_EQ(mostly_unsearched, static_cast<int>(stream.size()) - 1) << "all but the first";
  EXPECT_EQ(differences.poses(), score.expected);
  // Some of these small boards are fitted with all terms, which end a fit farther from its optimum.
  EXPECT_LT(std::sqrt(differences.position()), 0.25) << "standard deviations between poses with and without memory";
}

/// Robots whose second frame comes before their motion is known: they have moved by some cells.
std::string Rushing(int width, double distance_m, int robots, double speed) {
  char text[300];
  std::snprintf(text, sizeof text,
                "seed = 3\n[camera]\nsize = \"%dx%d\"\nfocal_px = %g\ndistance = %g\nfps = 30\nexposure_ms = 1\n"
                "[swarm]\nrobots = %d\nside = 0.1\nspeed = %g\n[[phase]]\nkind = \"calm\"\nframes = 8\n",
                width, width * 9 / 16, 0.75 * width, distance_m, robots, speed);
  return text;
}

TEST(Memory, ABoardThatTurnedOffCostsNoMoreThanASearch) {
  // Cells of 9 px, and robots that go up to 1.7 of them a frame and turn off: half a cell from where they are expected.
  const test::StreamFrames stream(
      "seed = 8\n[camera]\nsize = \"1280x720\"\nfocal_px = 2700\ndistance = 3.0\nfps = 30\nexposure_ms = 4\n"
      "[swarm]\nrobots = 30\nside = 0.06\nspeed = 0.5\n[[phase]]\nkind = \"calm\"\nframes = 16\n");
  constexpr std::size_t kUntilTheyDrive = 4;
  Follower follower(stream.Options());
  Detector cold(stream.Options());
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const test::StreamFrame frame = stream.Frame(i);
    const Detected& found = follower.Next(frame.image.view(), 33333us);
    const test::StreamScore score = test::ScoreFrame(found.markers, frame.truth);
    EXPECT_EQ(score.read, score.expected) << "frame " << i;
    EXPECT_EQ(score.wrong + score.twice, 0) << "frame " << i;
    if (i < kUntilTheyDrive) continue;
    cold.Detect(frame.image.view());
    // Where one such board was tried by all means, it was 2.3 and 2.9 times.
    EXPECT_LT(found.stats.work, cold.stats().work * 3 / 2) << "frame " << i;
  }
}

TEST(Memory, FramesThatComeTwiceTakeLittleMoreThanWithoutIt) {
  // As a camera in poor light may deliver them: robots halt and jump by turns, up to half a cell from where their
  // motion takes them, each its own way.
  const test::StreamFrames stream(
      "seed = 8\n[camera]\nsize = \"640x480\"\nfocal_px = 600\ndistance = 1.0\nfps = 30\nexposure_ms = 4\n"
      "[swarm]\nrobots = 8\nside = 0.1\nspeed = 0.25\n[[phase]]\nkind = \"calm\"\nframes = 24\n");
  constexpr std::size_t kUntilTheyDrive = 8;
  Follower follower(stream.Options());
  Detector cold(stream.Options());
  std::uint64_t with_memory = 0, without = 0;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const test::StreamFrame frame = stream.Frame(i);
    cold.Detect(frame.image.view());
    for (const int again : {0, 1}) {
      const Detected& found = follower.Next(frame.image.view());
      const test::StreamScore score = test::ScoreFrame(found.markers, frame.truth);
      EXPECT_EQ(score.read, score.expected) << "frame " << i << ", " << again;
      EXPECT_EQ(score.wrong + score.twice, 0) << "frame " << i << ", " << again;
      if (i < kUntilTheyDrive) continue;
      with_memory += found.stats.work;
      without += cold.stats().work;
    }
  }
  // Where boards of such cells were not followed, it was 1.6 times.
  EXPECT_LT(with_memory, without * 7 / 5);
}

TEST(Memory, SearchesForBoardsThatRanAwayBeforeItFitsThemWhereTheyWere) {
  const test::StreamFrames stream(Rushing(640, 1.2, 6, 2));
  Follower follower(stream.Options());
  std::uint64_t first = 0;
  for (const std::size_t i : {0u, 6u}) {
    const test::StreamFrame frame = stream.Frame(i);
    const Detected& found = follower.Next(frame.image.view(), 33333us);
    const test::StreamScore score = test::ScoreFrame(found.markers, frame.truth);
    EXPECT_EQ(score.read, score.expected) << "frame " << i;
    if (i == 0) first = found.stats.work;
    // Fits where the boards are not took three times as much.
    EXPECT_LE(found.stats.work, 2 * first) << "frame " << i;
  }
}

TEST(Memory, ReadsSmallBoardsThatRunWithABudgetThatDoesWithoutIt) {
  const test::StreamFrames stream(Rushing(960, 3, 30, 0.5));
  Detector cold(stream.Options());
  DetectorOptions options = stream.Options();
  cold.Detect(stream.Frame(0).image.view());
  options.budget = cold.stats().work * 3 / 8;
  Follower follower(options);
  test::StreamScore score;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const test::StreamFrame frame = stream.Frame(i);
    score += test::ScoreFrame(follower.Next(frame.image.view(), 33333us).markers, frame.truth);
  }
  // They turn off by up to a cell. Where each was fitted as far off as that, and what was found in the end had to do
  // without the budget that this took, 5 to 7 of 10 were read.
  EXPECT_GE(score.Recall(), 0.75) << score.read << " of " << score.expected;
}

TEST(SmallBoards, AreFittedAsWhereTheyAreAlone) {
  // Their cells blur into each other, which the first steps of those that know the image's blur do not show.
  const test::StreamFrames stream(Rushing(960, 3, 30, 0.1));
  DetectorOptions options = stream.Options();
  options.camera.reset();
  Detector all(options), one(options);
  double square = 0;
  int boards = 0;
  for (const std::size_t i : {0u, 4u}) {
    const test::StreamFrame frame = stream.Frame(i);
    for (const MarkerPose& marker : all.Detect(frame.image.view())) {
      constexpr int kReach = 24;
      int x = static_cast<int>(marker.center_px.x()) - kReach, y = static_cast<int>(marker.center_px.y()) - kReach,
          width = 2 * kReach, height = 2 * kReach;
      const std::vector<MarkerPose> alone = one.Detect(Crop(frame.image.view(), x, y, width, height));
      if (alone.size() != 1 || alone[0].id != marker.id) continue;
      square += (alone[0].center_px + Eigen::Vector2d(x, y) - marker.center_px).squaredNorm();
      ++boards;
    }
  }
  EXPECT_GT(boards, 50);
  EXPECT_LT(std::sqrt(square / boards), 0.001) << "px, RMS of " << boards;
}

/// What happens to five robots that have driven for ten frames.
struct Phase {
  const char* kind;  ///< "calm": they drive on
  const char* more;
  int seed, exposure_ms;
  int poses;    ///< that are compared, at least
  double most;  ///< standard deviations between poses with and without memory
  double dot_gain_cells = 0;
};

class PosesWithMemory : public testing::TestWithParam<Phase> {};

TEST_P(PosesWithMemory, AreThoseWithoutIt) {
  const Phase& phase = GetParam();
  std::string scenario = kDriving;
  const auto set = [&](const std::string& key, const char* as, int value) {
    scenario.replace(scenario.find(key + as), (key + as).size(), key + std::to_string(value));
  };
  set("seed = ", "5", phase.seed);
  set("focal_px = ", "800", 1100);
  set("exposure_ms = ", "1", phase.exposure_ms);
  if (phase.dot_gain_cells > 0)
    scenario.insert(scenario.find("robots = "), "ink_spread_cells = " + std::to_string(phase.dot_gain_cells) + "\n");
  const bool calm = std::string_view(phase.kind) == "calm";
  if (!calm) scenario = scenario + "[[phase]]\nkind = \"" + phase.kind + "\"\n" + phase.more;
  const test::StreamFrames stream{std::string_view(scenario)};
  const DetectorOptions options = stream.Options();
  Follower follower(options);
  Detector cold(options);
  test::PoseErrors differences;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const test::StreamFrame frame = stream.Frame(i);
    const Detected& found = follower.Next(frame.image.view());
    if (stream.phase(i) == phase.kind) differences.AddDifferences(cold.Detect(frame.image.view()), found.markers);
  }
  EXPECT_GT(differences.poses(), phase.poses);
  EXPECT_LT(std::sqrt(differences.position()), phase.most)
      << "standard deviations between poses with and without memory";
}

INSTANTIATE_TEST_SUITE_P(
    Memory, PosesWithMemory,
    testing::Values(
        // They are fitted to the same pixels, wherever a fit began (those at the rim fade out by where the board lies),
        // until another step would not count.
        Phase{"calm", "", 5, 1, 30, 0.06},
        // 0.39 where saturated pixels keep the noise from being told.
        Phase{"bright", "light = 2.0\nframes = 12\n", 5, 1, 50, 0.09},
        // 0.48 where each board tells the noise for itself, and where boards end with a model that their pixels deny.
        Phase{"knock", "max_px = 14\nframes = 16\n", 5, 1, 60, 0.13},
        // 0.09 where they keep the pixels that they began with.
        Phase{"hands", "frames = 16\n", 5, 1, 60, 0.07},
        // 0.10 where boards that move tell edges.
        Phase{"fast", "speed = 1.5\nframes = 16\n", 1, 4, 60, 0.08},
        // 0.26 and more where boards with dot gain were fitted with all terms, 0.4 where moved ones told none.
        Phase{"calm", "", 5, 1, 30, 0.06, 0.01}, Phase{"knock", "max_px = 14\nframes = 16\n", 5, 1, 60, 0.27, 0.02},
        Phase{"fast", "speed = 1.5\nframes = 16\n", 1, 4, 60, 0.08, 0.04},
        // 0.80 where overexposed boards told none.
        Phase{"bright", "light = 2.0\nframes = 12\n", 5, 1, 50, 0.07, 0.02}),
    [](const auto& tested) {
      return std::string(tested.param.kind) + (tested.param.dot_gain_cells > 0 ? "OfBledInk" : "");
    });

TEST(Memory, OfADotGainIsKeptWhereTheCameraIsKnocked) {
  // Boards that began with the motion of the camera did without: squared errors of 1.9 and 8.9.
  std::string scenario = kDriving;
  const std::string robots = "robots = 5\n";
  scenario.replace(scenario.find(robots), robots.size(), "robots = 8\nink_spread_cells = 0.04\n");
  scenario.replace(scenario.find("focal_px = 800"), 14, "focal_px = 1100");
  const test::StreamFrames stream(scenario + "[[phase]]\nkind = \"knock\"\nmax_px = 14\nframes = 12\n");
  Follower follower(stream.Options());
  test::PoseErrors errors;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const test::StreamFrame frame = stream.Frame(i);
    const Detected& found = follower.Next(frame.image.view());
    if (stream.phase(i) != "knock") continue;
    for (const MarkerPose& marker : found.markers)
      for (const TrueMarker& truth : frame.truth.markers)
        if (marker.id == truth.id) errors.Add(truth.camera_from_marker, marker);
  }
  EXPECT_GT(errors.poses(), 80);
  EXPECT_LT(errors.position(), 1.5);
  EXPECT_LT(errors.orientation(), 1.5);
}

TEST(Memory, OfADotGainEndsWithAGap) {
  // A frame after the gap began with it.
  std::string scenario = kDriving;
  scenario.insert(scenario.find("robots = "), "ink_spread_cells = 0.04\n");
  const test::StreamFrames stream{std::string_view(scenario)};
  Follower follower(stream.Options()), fresh(stream.Options());
  for (std::size_t i = 0; i < 3; ++i) follower.Next(stream.Frame(i).image.view());
  const Image image = stream.Frame(3).image;
  EXPECT_EQ(DifferenceOf(fresh.Next(image.view()), follower.Next(image.view(), 1h)), "");
}

/// A robot of kDriving alone, for so many frames.
std::string Alone(int frames) {
  std::string scenario = kDriving;
  scenario.replace(scenario.find("robots = 5"), 10, "robots = 1");
  scenario.replace(scenario.find("frames = 10"), 11, "frames = " + std::to_string(frames));
  return scenario;
}

TEST(Memory, AsksForEdgesAndDotGainInTurns) {
  // Where there are neither. A board alone took as much in every frame as in those that ask.
  const test::StreamFrames stream(Alone(100));
  Follower follower(stream.Options());
  std::vector<std::uint64_t> told, known;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const Detected& found = follower.Next(stream.Frame(i).image.view());
    ASSERT_EQ(found.markers.size(), 1u) << "frame " << i;
    // The first frames are searched as a whole.
    const MemoryState& state = follower.memory().state();
    ASSERT_TRUE(state.simple_traits) << "frame " << i;
    if (i >= 4) (state.traits_age == 0 ? told : known).push_back(found.stats.work);
  }
  EXPECT_EQ(told.size(), 6u) << "of 96 frames, one in 16";
  const auto mean = [](const std::vector<std::uint64_t>& works) {
    return static_cast<double>(std::accumulate(works.begin(), works.end(), std::uint64_t{0})) /
           static_cast<double>(works.size());
  };
  EXPECT_LT(mean(known), 0.95 * mean(told));
  // Where there is no gain, a glance tells: fits with a little more and less of it took 1.35 times a frame that does
  // not ask.
  EXPECT_LT(mean(told), 1.15 * mean(known));
}

TEST(Memory, TakesLessLightForNothingElse) {
  std::string fading = kDriving;
  fading += "[[phase]]\nkind = \"dark\"\nlight = 0.2\nframes = 6\n";
  const test::StreamFrames stream{std::string_view(fading)};
  Follower follower(stream.Options());
  // Until then it is learnt how they move.
  constexpr std::size_t kFollowed = 3;
  std::uint64_t light = 0, dark = 0, light_frames = 0, dark_frames = 0;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const test::StreamFrame frame = stream.Frame(i);
    const std::uint64_t work = follower.Next(frame.image.view()).stats.work;
    const bool is_dark = stream.phase(i) == "dark";
    (is_dark ? dark : light) += i < kFollowed ? 0 : work;
    (is_dark ? dark_frames : light_frames) += i < kFollowed ? 0 : 1;
    // Taken for a knock of the camera, less light doubled the work of its first frame. Later frames took five times as
    // much, until the remembered contrast had fallen as far.
    if (is_dark && stream.phase(i - 1) != "dark") {
      EXPECT_LT(work * light_frames, light) << "where the light falls";
    }
  }
  EXPECT_LT(dark * light_frames * 10, light * dark_frames * 12)
      << dark << " units in the dark, " << light << " in light";
}

TEST(Memory, BeginsOverexposedBoardsAboveFullScale) {
  // From full scale, where edges alone tell the levels, fits took five passes: .69 times the work of cold frames.
  std::string scenario = kDriving;
  scenario += "[[phase]]\nkind = \"bright\"\nlight = 2\nframes = 10\n";
  const test::StreamFrames stream{std::string_view(scenario)};
  Follower follower(stream.Options());
  Detector cold(stream.Options());
  std::uint64_t with_memory = 0, without = 0;
  bool was_bright = false;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const test::StreamFrame frame = stream.Frame(i);
    const Detected& found = follower.Next(frame.image.view());
    const bool bright = stream.phase(i) == "bright";
    if (bright && was_bright) {
      with_memory += found.stats.work;
      cold.Detect(frame.image.view());
      without += cold.stats().work;
    }
    was_bright = bright;
  }
  EXPECT_LT(20 * with_memory, 11 * without) << with_memory << " units with memory, " << without << " without";
}

TEST(Memory, MakesTheSameOfTheSameFrames) {
  const test::StreamFrames stream{std::string_view(kDriving)};
  DetectorOptions options = stream.Options();
  Follower one(options);
  options.threads = 3;
  Follower other(options);
  for (std::size_t i = 0; i < 6; ++i) {
    const Image image = stream.Frame(i).image;
    const Detected first = one.Next(image.view());
    // From the memory before a frame, it can be begun again.
    const DetectorMemory before = other.memory();
    EXPECT_EQ(DifferenceOf(first, other.Next(image.view())), "") << "frame " << i;
    EXPECT_EQ(before.boards() > 0, i > 0) << "frame " << i;
  }
}

TEST(Memory, ForgetsABlurThatIsNone) {
  std::string near(kDriving);
  near.replace(near.find("focal_px = 800"), 14, "focal_px = 1500");
  const test::StreamFrames stream{std::string_view(near)};
  Follower follower(stream.Options()), misled(stream.Options());
  for (std::size_t i = 0; i < 5; ++i) {
    follower.Next(stream.Frame(i).image.view());
    misled.Next(stream.Frame(i).image.view());
  }
  // As after the last frame of a knock. Without the blur that it brings, what is left is less than a pixel's own.
  for (RememberedBoard& board : misled.memory().state().boards) board.blur_shape = {{-0.7, 4.4}, 0.01};
  const test::StreamFrame frame = stream.Frame(5);
  const Detected &found = follower.Next(frame.image.view()), &again = misled.Next(frame.image.view());
  ASSERT_EQ(again.markers.size(), found.markers.size());
  test::PoseErrors differences;
  differences.AddDifferences(again.markers, found.markers);
  EXPECT_EQ(differences.poses(), static_cast<int>(found.markers.size()));
  EXPECT_LT(differences.position(), 0.1);
  EXPECT_LT(differences.orientation(), 0.1);
  for (const MarkerPose& marker : again.markers) EXPECT_FALSE(marker.Has(Warning::kPoorFit)) << *marker.id;
}

TEST(Memory, ForgetsAMotionThatIsNone) {
  const test::StreamFrames stream{std::string_view(kDriving)};
  Follower follower(stream.Options());
  for (std::size_t i = 0; i < 4; ++i) follower.Next(stream.Frame(i).image.view());
  constexpr double kWrongPx = 10;
  for (RememberedBoard& board : follower.memory().state().boards) board.motion.before(0, 2) -= kWrongPx;
  follower.Next(stream.Frame(4).image.view());
  EXPECT_EQ(follower.memory().boards(), 5u);
  for (const RememberedBoard& board : follower.memory().state().boards)
    EXPECT_LT((board.plane_from_board - board.motion.before).col(2).head<2>().norm(), kWrongPx / 2) << board.id;
}

TEST(Memory, LeavesADetectorAsItWas) {
  const Image image = WithMarker(3).Draw();
  Follower follower(OptionsFor(WithMarker(3)));
  follower.Next(image.view());
  follower.Next(image.view());
  Detected found, expected;
  follower.detector().Detect(image.view(), found.markers);
  found.stats = follower.detector().stats();
  Detector fresh(OptionsFor(WithMarker(3)));
  fresh.Detect(image.view(), expected.markers);
  expected.stats = fresh.stats();
  EXPECT_EQ(DifferenceOf(expected, found), "");
}

TEST(Memory, FindsNewBoardsInTheirTurn) {
  const Image empty = Empty().Draw(), image = WithMarker(3).Draw();
  for (const int every : {1, 4}) {
    DetectorOptions options = OptionsFor(WithMarker(3));
    options.search_every = every;
    Follower follower(options);
    follower.Next(empty.view());
    int frames = 1;
    while (follower.Next(image.view()).markers.empty() && frames < 10) ++frames;
    EXPECT_LE(frames, every);
  }
}

TEST(Memory, FindsNewBoardsWhereverTheyLieAndHoweverLargeTheyAre) {
  const Image empty = Empty().Draw();
  for (const double height_m : {-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3})
    for (const double nearer : {1.0, 0.3}) {
      test::KnownFrame frame = WithMarker(3);
      Eigen::Vector3d& at = frame.scene.markers[0].camera_from_marker.translation;
      at.y() = height_m;
      at *= nearer;
      const Image image = frame.Draw();
      DetectorOptions options = OptionsFor(frame);
      Detector whole(options);
      if (whole.Detect(image.view()).empty()) continue;
      for (int before = 1; before <= 4; ++before) {
        Follower follower(options);
        for (int i = 0; i < before; ++i) follower.Next(empty.view());
        int frames = 1;
        while (follower.Next(image.view()).markers.empty() && frames < 10) ++frames;
        EXPECT_LE(frames, 4) << height_m << " m off, " << nearer << " of the distance, after " << before << " frames";
      }
    }
}

TEST(Memory, SearchesAsMuchInEveryFrame) {
  const Image image = WithMarker(3).Draw();
  const std::int64_t all = std::int64_t{image.width()} * image.height();
  for (const int every : {1, 2, 4, 5, 16}) {
    DetectorOptions options = OptionsFor(WithMarker(3));
    options.search_every = every;
    Follower follower(options);
    follower.Next(image.view());
    std::int64_t sum = 0;
    for (int i = 0; i < every; ++i) {
      const std::int64_t searched = follower.Next(image.view()).stats.searched_px;
      EXPECT_LE(searched, every == 1 ? all : every == 2 ? all * 6 / 10 : all * 4 / 10) << "every " << every;
      sum += searched;
    }
    EXPECT_GE(sum, all) << "every " << every;
    EXPECT_LE(sum, all * 14 / 10) << "every " << every;
  }
}

TEST(Memory, SearchesWhatOthersMayHaveDroppedAfterTwiceTheTime) {
  MemoryState state;
  const FrameTime start(1);
  std::vector<RememberedBoard> none;
  state.Continue(start, 640, 480);
  MemoryState::Lesson lesson;
  lesson.now = start;
  lesson.searched.fill(true);
  state.Learn(lesson, none);
  lesson.frames_on = 2;
  std::array<int, 4> since{};
  // Of two frames, one is always another's.
  for (int frame = 0; frame < 40; ++frame) {
    for (int band = 0; band < 4; ++band) {
      const std::size_t i = static_cast<std::size_t>(band);
      lesson.searched[i] = state.HasTurn(band, 4, 4, 2);
      since[i] = lesson.searched[i] ? 0 : since[i] + 2;
      EXPECT_LE(since[i], 8) << "band " << band;
    }
    state.Learn(lesson, none);
  }
}

TEST(Memory, ReadsAnotherBoardWhereOneWas) {
  Follower follower(OptionsFor(WithMarker(3)));
  EXPECT_EQ(IdsOf(follower.Next(WithMarker(3).Draw().view())), Ids{3});
  EXPECT_EQ(IdsOf(follower.Next(WithMarker(3).Draw().view())), Ids{3});
  EXPECT_EQ(IdsOf(follower.Next(WithMarker(1234).Draw().view())), Ids{1234}) << "in the same frame";
  EXPECT_EQ(IdsOf(follower.Next(WithMarker(1234).Draw().view())), Ids{1234});
}

TEST(Memory, FindsALostBoardAtOnce) {
  const Image empty = Empty().Draw(), image = WithMarker(3).Draw();
  DetectorOptions options = OptionsFor(WithMarker(3));
  options.search_every = 64;
  Follower follower(options);
  EXPECT_EQ(IdsOf(follower.Next(image.view())), Ids{3});
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(IdsOf(follower.Next(empty.view())), Ids{});
    EXPECT_LT(follower.memory().boards(), 1u);
  }
  EXPECT_EQ(IdsOf(follower.Next(image.view())), Ids{3});
  EXPECT_LT(follower.Next(image.view()).stats.searched_px, 1);
}

TEST(Memory, SearchesAllOfAnotherPicture) {
  const Image image = WithMarker(3).Draw();
  test::KnownFrame other = WithMarker(3);
  other.scene.markers[0].camera_from_marker.translation += Eigen::Vector3d(0.25, -0.2, 0);
  const Image cut = other.Draw();
  // With a budget, boards that the plain fit does not find wait for the others: they are missing all the same.
  for (const std::uint64_t budget : {0u, 100'000u}) {
    DetectorOptions options = OptionsFor(WithMarker(3));
    options.search_every = 64;
    options.budget = budget;
    Follower follower(options);
    follower.Next(image.view());
    EXPECT_EQ(IdsOf(follower.Next(image.view())), Ids{3});
    EXPECT_EQ(IdsOf(follower.Next(cut.view())), Ids{3}) << "of the same frame, budget " << budget;
  }
}

TEST(Memory, TakesAKnockForNoOtherPicture) {
  std::string knocked = kDriving;
  knocked += "[[phase]]\nkind = \"knock\"\nmax_px = 12\nframes = 20\n";
  const test::StreamFrames stream{std::string_view(knocked)};
  DetectorOptions options = stream.Options();
  options.budget = 100'000;
  Follower follower(options);
  test::StreamScore score;
  int searched_all = 0;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const test::StreamFrame frame = stream.Frame(i);
    const Detected& found = follower.Next(frame.image.view());
    if (stream.phase(i) != "knock") continue;
    score += test::ScoreFrame(found.markers, frame.truth);
    searched_all += found.stats.searched_px == std::int64_t{frame.image.width()} * frame.image.height();
  }
  // A search takes less than a fit in vain: where most boards were just found again, and their motion is not known, all
  // of the image is searched.
  EXPECT_LE(searched_all, 7);
  EXPECT_EQ(score.wrong + score.twice, 0);
  EXPECT_GT(score.Recall(), 0.8);
}

TEST(Memory, EndsWithGapsSizesAndTimesThatGoBack) {
  const Image image = WithMarker(3).Draw();
  const std::int64_t all = std::int64_t{image.width()} * image.height();
  Follower follower(OptionsFor(WithMarker(3)));
  EXPECT_EQ(follower.Next(image.view()).stats.searched_px, all);
  EXPECT_LT(follower.Next(image.view()).stats.searched_px, all / 2);
  EXPECT_EQ(follower.Next(image.view(), 300ms).stats.searched_px, all);
  EXPECT_LT(follower.Next(image.view()).stats.searched_px, all / 2);
  EXPECT_EQ(follower.Next(image.view(), -1ms).stats.searched_px, all);
  EXPECT_LT(follower.Next(image.view()).stats.searched_px, all / 2);
  int x = 0, y = 0, width = image.width() - 40, height = image.height();
  follower.Next(Crop(image.view(), x, y, width, height));
  EXPECT_EQ(follower.detector().stats().searched_px, std::int64_t{width} * height);
  follower.memory().Clear();
  EXPECT_EQ(follower.memory().boards(), 0u);
}

TEST(Memory, IsBounded) {
  const Image image = WithMarker(3).Draw();
  Follower follower(OptionsFor(WithMarker(3)));
  follower.Next(image.view());
  const std::size_t bytes = follower.memory().bytes();
  EXPECT_LT(bytes, 8000u) << "of a board";
  for (int i = 0; i < 20; ++i) follower.Next(image.view());
  EXPECT_EQ(follower.memory().bytes(), bytes);
}

/// Puts something dull on the left part of a board.
void Occlude(const SceneMarker& marker, const CameraModel& camera, double share, Image& image) {
  const std::vector<Eigen::Vector2d> corners = test::InnerCorners(marker, camera);
  Eigen::Vector2d least = corners[0], most = corners[0];
  for (const Eigen::Vector2d& corner : corners) least = least.cwiseMin(corner), most = most.cwiseMax(corner);
  const Eigen::Vector2d cell = (most - least) / 4;
  const int left = static_cast<int>(least.x() - 2 * cell.x()),
            right = static_cast<int>(least.x() - cell.x() + share * 6 * cell.x()),
            top = static_cast<int>(least.y() - 2 * cell.y()), bottom = static_cast<int>(most.y() + 2 * cell.y());
  for (int y = top; y <= bottom; ++y)
    std::fill_n(image.bytes().data() + 3 * (y * image.width() + left), 3 * (right - left), std::uint8_t{110});
}

/// Every board under something dull in its left part.
Image Occluded(const test::KnownFrame& frame, double share) {
  Image image = frame.Draw();
  for (const SceneMarker& marker : frame.scene.markers) Occlude(marker, frame.options.camera, share, image);
  return image;
}

TEST(Memory, CarriesTheIdentityOfABoardThatIsOccluded) {
  const test::KnownFrame frame = WithMarker(3);
  const Image plain = frame.Draw(), occluded = Occluded(frame, 0.4);
  DetectorOptions options = OptionsFor(frame);
  options.carry_s = 0.1;
  MarkerFamily& family = options.families[0];
  family.printed_by_id_m[3] = {1.02 * family.side_m, family.side_m};
  for (const MarkerPose& marker : Detector(options).Detect(occluded.view()))
    ASSERT_FALSE(marker.id) << "too little shows";
  Follower follower(options);
  follower.Next(plain.view());
  int carried = 0;
  for (int i = 0; i < 10; ++i) {
    const Detected& found = follower.Next(occluded.view());
    for (const MarkerPose& marker : found.markers) {
      if (!marker.id) continue;
      EXPECT_EQ(marker.id, 3u);
      EXPECT_TRUE(marker.Has(Warning::kIdCarried));
      EXPECT_FALSE(marker.Has(Warning::kIdUndecided));
      EXPECT_EQ(marker.measurement.cell_m, family.CellM(3).x()) << "as wide as that board";
      ++carried;
    }
  }
  EXPECT_EQ(carried, 5) << "for 0.1 s";
  EXPECT_EQ(IdsOf(follower.Next(plain.view())), Ids{3});
}

/// Boards of these ids beside each other, each `to_right_m` from where it belongs.
test::KnownFrame Row(const Ids& ids, const std::vector<double>& to_right_m = {}) {
  test::KnownFrame frame = WithMarker(ids[0]);
  const SceneMarker first = frame.scene.markers[0];
  frame.scene.markers.clear();
  for (std::size_t i = 0; i < ids.size(); ++i) {
    SceneMarker marker = test::MarkerOf(kCode, ids[i], first.camera_from_marker, first.side_m);
    const double at = static_cast<double>(i) - 0.5 * static_cast<double>(ids.size() - 1);
    marker.camera_from_marker.translation.x() += 1.6 * first.side_m * at + (to_right_m.empty() ? 0 : to_right_m[i]);
    frame.scene.markers.push_back(marker);
  }
  return frame;
}

/// Of markers with an id, those that are not where that board truly is.
int WrongIds(const Detected& found, const test::KnownFrame& frame) {
  int wrong = 0;
  const std::vector<TrueMarker> truth = frame.Truth();
  for (const MarkerPose& marker : found.markers)
    wrong += marker.id && std::none_of(truth.begin(), truth.end(), [&](const TrueMarker& board) {
               return board.id == marker.id &&
                      (board.camera_from_marker.translation - marker.camera_from_marker.translation).norm() < 0.05;
             });
  return wrong;
}

TEST(Memory, CarriesNoIdToABoardThatTookThePlaceOfAnother) {
  for (const auto& [first, second] : {std::pair<std::uint64_t, std::uint64_t>{3, 1234}, {100, 101}, {7, 1000}}) {
    const test::KnownFrame before = Row({first, second}), after = Row({second, first});
    for (const double share : {0.2, 0.38, 0.5, 1.2}) {
      Follower follower(OptionsFor(before));
      int wrong = 0;
      for (int i = 0; i < 3; ++i) wrong += WrongIds(follower.Next(before.Draw().view()), before);
      for (int i = 0; i < 3; ++i) wrong += WrongIds(follower.Next(Occluded(before, share).view()), before);
      for (int i = 0; i < 3; ++i) wrong += WrongIds(follower.Next(Occluded(after, share).view()), after);
      const Detected& found = follower.Next(after.Draw().view());
      wrong += WrongIds(found, after);
      EXPECT_EQ(wrong, 0) << first << ", " << second << ", occluded by " << share;
      EXPECT_EQ(IdsOf(found).size(), 2u);
    }
  }
}

TEST(Memory, KeepsApartBoardsThatPassEachOther) {
  // Side by side at 2 m/s, and one above the other where they meet, half occluded there.
  for (const bool occluded : {false, true}) {
    test::KnownFrame frame = Row({3, 1234});
    Follower follower(OptionsFor(frame));
    int wrong = 0, read = 0, frames = 0;
    for (double way = -0.16; way <= 0.16; way += 0.0333, ++frames) {
      frame = Row({3, 1234}, {0.096 + way, -0.096 - way});
      for (std::size_t i = 0; i < 2; ++i)
        frame.scene.markers[i].camera_from_marker.translation.y() += i == 0 ? 0.065 : -0.065;
      const Image image = occluded && std::abs(way) < 0.08 ? Occluded(frame, 0.38) : frame.Draw();
      const Detected& found = follower.Next(image.view());
      wrong += WrongIds(found, frame);
      read += static_cast<int>(IdsOf(found).size());
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_GE(read, occluded ? frames : 2 * frames);
  }
}

TEST(Memory, FollowsCopiesOfAMarkerEachByItself) {
  // Three of one id and one of another go each its own way, from rest, and are read in every frame.
  const Ids ids{3, 3, 1234, 3};
  Follower follower(OptionsFor(Row(ids)));
  for (int i = 0; i < 14; ++i) {
    test::KnownFrame frame = Row(ids, {0.004 * i, 0.004 * i, -0.004 * i, -0.004 * i});
    for (std::size_t k = 0; k < ids.size(); ++k)
      frame.scene.markers[k].camera_from_marker.translation.y() += (k % 2 == 0 ? 0.007 : -0.005) * i;
    const Detected& found = follower.Next(frame.Draw().view());
    EXPECT_EQ(WrongIds(found, frame), 0) << i;
    EXPECT_EQ(IdsOf(found).size(), ids.size()) << i;
  }
  EXPECT_EQ(follower.memory().boards(), ids.size());
}

TEST(Memory, FollowsABoardThatIsPutDownElsewhere) {
  test::KnownFrame frame = Row({3, 1234});
  Follower follower(OptionsFor(frame));
  follower.Next(frame.Draw().view());
  follower.Next(Occluded(frame, 0.38).view());
  // It lies elsewhere, and another where it was, still under the hand.
  test::KnownFrame both = Row({99, 1234});
  both.scene.markers.push_back(frame.scene.markers[0]);
  both.scene.markers[2].camera_from_marker.translation.y() += 0.17;
  Image image = both.Draw();
  Occlude(both.scene.markers[0], both.options.camera, 0.38, image);
  for (int i = 0; i < 5; ++i) {
    const Detected& found = follower.Next(image.view());
    EXPECT_EQ(WrongIds(found, both), 0) << i;
    const Ids ids = IdsOf(found);
    if (i == 4) {
      EXPECT_EQ(std::count(ids.begin(), ids.end(), 3u), 1);
    }
  }
}

}  // namespace
}  // namespace chequer
