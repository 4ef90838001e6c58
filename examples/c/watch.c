/* watch PREFIX ROBOT|ID: prints a robot's track, or a marker's pose where a number is given, as it comes, until nothing
   came for five seconds. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "chequer_client.h"

int main(int argc, char** argv) {
  if (argc != 3) {
    fprintf(stderr, "usage: watch PREFIX ROBOT|ID, such as: watch CHEQUER_ceiling alice\n");
    return 2;
  }
  chequer_client* client = chequer_open(argv[1], NULL);
  if (client == NULL) {
    fprintf(stderr, "watch: LCM cannot be opened; without a network: ip route add 224.0.0.0/4 dev lo\n");
    return 1;
  }
  char* end;
  const uint64_t id = strtoull(argv[2], &end, 10);
  chequer_target* target = *end == '\0' ? chequer_watch_marker(client, id) : chequer_watch_track(client, argv[2]);
  fprintf(stderr, "watching %s\n", argv[2]);
  chequer_state state;
  int seen = 0;
  while (target != NULL && chequer_new(target, &state, 5000)) {
    seen = 1;
    printf("%s %.4f %.4f m, heading %.4f rad, %.4f m/s, %.4f rad/s\n", argv[2], state.position[0], state.position[1],
           state.heading, hypot(state.velocity[0], state.velocity[1]), state.yaw_rate);
    fflush(stdout);
  }
  chequer_close(client);
  return seen ? 0 : 1;
}
