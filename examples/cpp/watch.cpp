// watch PREFIX ROBOT: prints the track of a robot as it comes, until none came for five seconds.
#include <cmath>
#include <cstdio>

#include "chequer_client.h"

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: watch PREFIX ROBOT, such as: watch CHEQUER_ceiling alice\n");
    return 2;
  }
  try {
    chequer::client::Target<chequer::track_t> robot;
    chequer::client::Client client(argv[1]);
    client.WatchTrack(argv[2], robot);
    client.Start();
    std::fprintf(stderr, "watching %s\n", argv[2]);
    bool seen = false;
    while (const auto track = robot.New(std::chrono::seconds(5))) {
      seen = true;
      std::printf("%s %.4f %.4f m, heading %.4f rad, %.4f m/s, %.4f rad/s%s\n", track->name.c_str(), track->position[0],
                  track->position[1], track->heading, std::hypot(track->velocity[0], track->velocity[1]),
                  track->angular_velocity[2], track->coasting != 0 ? ", coasting" : "");
      std::fflush(stdout);
    }
    if (!seen)
      std::fprintf(stderr, "watch: no track of %s came; is [tracks] enabled, and the robot in the roster?\n", argv[2]);
    return seen ? 0 : 1;
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "watch: %s\n", error.what());
    return 1;
  }
}
