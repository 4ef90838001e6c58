// follow PREFIX LEADER FOLLOWER: drives one robot after another, 0.3 m behind it, by their tracks.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <example/drive_t.hpp>
#include <numbers>

#include "chequer_client.h"

int main(int argc, char** argv) try {
  if (argc != 4) throw std::runtime_error("usage: follow PREFIX LEADER FOLLOWER");
  chequer::client::Target<chequer::track_t> leader, follower;
  chequer::client::Client client(argv[1]);
  client.WatchTrack(argv[2], leader);
  client.WatchTrack(argv[3], follower);
  client.Start();
  const std::string channel = std::string(argv[3]) + "_DRIVE";
  while (true) {
    example::drive_t drive{};  // stands still unless both are seen
    const auto me = follower.New(std::chrono::milliseconds(200));
    const auto goal = leader.Latest();
    if (me && goal && goal->since_seen_us < 500'000) {
      const double dx = goal->position[0] - me->position[0], dy = goal->position[1] - me->position[1];
      const double off_course = std::remainder(std::atan2(dy, dx) - me->heading, 2 * std::numbers::pi);
      const double too_far = std::hypot(dx, dy) - 0.3;
      drive.speed = std::clamp(1.5 * too_far * std::max(0.0, std::cos(off_course)), 0.0, 0.5);
      drive.yaw_rate = std::clamp(3 * off_course, -2.0, 2.0);
    }
    client.lcm().publish(channel, &drive);
  }
} catch (const std::runtime_error& error) {
  std::fprintf(stderr, "follow: %s\n", error.what());
  return 1;
}
