// watch PREFIX ROBOT|ID: prints a robot's track, or a marker's pose where a number is given, as it comes, until nothing
// came for five seconds.
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "chequer_client.h"

namespace {

constexpr std::chrono::seconds kPatience{5};

/// @returns whether anything came.
bool PrintTrack(chequer::client::Target<chequer::track_t>& robot) {
  bool seen = false;
  while (const auto track = robot.New(kPatience)) {
    seen = true;
    std::printf("%s %.4f %.4f m, heading %.4f rad, %.4f m/s, %.4f rad/s%s\n", track->name.c_str(), track->position[0],
                track->position[1], track->heading, std::hypot(track->velocity[0], track->velocity[1]),
                track->angular_velocity[2], track->coasting != 0 ? ", coasting" : "");
    std::fflush(stdout);
  }
  return seen;
}

bool PrintMarker(const char* id, chequer::client::Target<chequer::marker_pose_t>& marker) {
  bool seen = false;
  while (const auto pose = marker.New(kPatience)) {
    seen = true;
    std::printf("%s %.4f %.4f m\n", id, pose->position[0], pose->position[1]);
    std::fflush(stdout);
  }
  return seen;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: watch PREFIX ROBOT|ID, such as: watch CHEQUER_ceiling alice\n");
    return 2;
  }
  try {
    chequer::client::Target<chequer::track_t> robot;
    chequer::client::Target<chequer::marker_pose_t> marker;
    chequer::client::Client client(argv[1]);
    char* end = nullptr;
    const auto id = std::strtoull(argv[2], &end, 10);
    const bool is_marker = *end == '\0';
    if (is_marker)
      client.WatchMarker(id, marker);
    else
      client.WatchTrack(argv[2], robot);
    client.Start();
    std::fprintf(stderr, "watching %s\n", argv[2]);
    if (is_marker ? PrintMarker(argv[2], marker) : PrintTrack(robot)) return 0;
    std::fprintf(stderr,
                 is_marker ? "watch: marker %s was not seen\n"
                           : "watch: no track of %s came; is [tracks] enabled, and the robot in the roster?\n",
                 argv[2]);
    return 1;
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "watch: %s\n", error.what());
    return 1;
  }
}
