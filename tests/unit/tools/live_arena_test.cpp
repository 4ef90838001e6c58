#include "tools/live_arena.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <sstream>

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::HasSubstr;
using ::testing::Not;

MonotonicTime ArenaTime(int ms) { return MonotonicTime(seconds(100) + milliseconds(ms)); }

TracksMessage TrackAt(const std::string& name, double x, double y, double heading_rad) {
  TracksMessage message;
  message.header.frame = "world";
  TrackState track;
  track.key.robot = name;
  track.frame_from_body = {RotationFromVector({0, 0, heading_rad}), {x, y, 0}};
  message.tracks.push_back(track);
  return message;
}

struct Place {
  int row = -1, column = -1;
};

/// Where a text stands; columns in characters.
Place Find(const std::string& map, const std::string& text) {
  std::istringstream lines(map);
  std::string line;
  for (int row = 0; std::getline(lines, line); ++row)
    if (const auto at = line.find(text); at != std::string::npos) {
      int column = 0;
      for (std::size_t i = 0; i < at; ++i) column += (line[i] & 0xc0) != 0x80 ? 1 : 0;
      return {row, column};
    }
  return {};
}

TEST(LiveArena, PutsRobotsWhereTheyAre) {
  LiveArena arena;
  arena.Add("a_TRACKS", TrackAt("west", -1, 0, 0), ArenaTime(0));
  arena.Add("a_TRACKS", TrackAt("east", 1, 0, std::numbers::pi / 2), ArenaTime(0));
  arena.Add("a_TRACKS", TrackAt("north", 0, 1, std::numbers::pi), ArenaTime(0));
  const std::string map = arena.Text(ArenaTime(100), 24, 80);
  const Place west = Find(map, "→west"), east = Find(map, "↑east"), north = Find(map, "←north");
  ASSERT_NE(west.row, -1) << map;
  ASSERT_NE(east.row, -1) << map;
  ASSERT_NE(north.row, -1) << map;
  EXPECT_EQ(west.row, east.row);
  EXPECT_LT(north.row, west.row) << "y is up";
  EXPECT_NEAR(north.column, (west.column + east.column) / 2.0, 1);
  EXPECT_NEAR(east.column - west.column, 2 * 2 * (west.row - north.row), 3)
      << "two metres across, one up, in characters twice as high as wide";
  EXPECT_THAT(map, HasSubstr("3 in the world"));
}

TEST(LiveArena, IsAsLargeAsItMayBe) {
  LiveArena arena;
  for (int i = 0; i < 100; ++i)
    arena.Add("a_TRACKS", TrackAt("a robot of a long name " + std::to_string(i), i, -i, i), ArenaTime(0));
  const std::string map = arena.Text(ArenaTime(0), 10, 40);
  std::istringstream lines(map);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    int columns = 0;
    for (const char c : line) columns += (c & 0xc0) != 0x80 ? 1 : 0;
    EXPECT_LE(columns, 40);
  }
  EXPECT_EQ(count, 10);
}

TEST(LiveArena, ForgetsWhoHasGoneAndSaysWhoIsLost) {
  LiveArena arena;
  arena.Add("a_TRACKS", TrackAt("alice", 0, 0, 0), ArenaTime(0));
  EXPECT_THAT(arena.Text(ArenaTime(1000), 10, 60), HasSubstr(".alice lost"));
  EXPECT_THAT(arena.Text(ArenaTime(4000), 10, 60), HasSubstr("nobody"));
}

TEST(LiveArena, PrefersTracksToMarkers) {
  LiveArena arena;
  PosesMessage poses;
  MarkerPose marker;
  marker.id = 17;
  marker.has_pose = true;
  poses.markers.push_back(marker);
  arena.Add("a_POSES", poses, ArenaTime(0));
  EXPECT_THAT(arena.Text(ArenaTime(0), 10, 60), HasSubstr("17"));
  LiveArena with_tracks;
  with_tracks.Add("a_TRACKS", TrackAt("alice", 0, 0, 0), ArenaTime(0));
  with_tracks.Add("a_POSES", poses, ArenaTime(10));
  EXPECT_THAT(with_tracks.Text(ArenaTime(10), 10, 60), Not(HasSubstr("17")));
}

TEST(LiveArena, ANameFromTheNetworkMovesNoCursor) {
  LiveArena arena;
  arena.Add("a_TRACKS", TrackAt("\x1b[2Jx", 0, 0, 0), ArenaTime(0));
  EXPECT_THAT(arena.Text(ArenaTime(0), 10, 60), Not(HasSubstr("\x1b")));
}

}  // namespace
}  // namespace chequer
