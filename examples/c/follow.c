/* follow PREFIX LEADER FOLLOWER: drives one robot after another, 0.3 m behind it, by their tracks. */
#include <math.h>
#include <stdio.h>

#include "chequer_client.h"
#include "example_drive_t.h"

static double clamp(double value, double least, double most) { return fmin(fmax(value, least), most); }

int main(int argc, char** argv) {
  chequer_client* client = argc == 4 ? chequer_open(argv[1], NULL) : NULL;
  if (client == NULL) {
    fprintf(stderr, "usage: follow PREFIX LEADER FOLLOWER; LCM must be reachable (ip route add 224.0.0.0/4 dev lo)\n");
    return 1;
  }
  chequer_target *leader = chequer_watch_track(client, argv[2]), *follower = chequer_watch_track(client, argv[3]);
  char channel[LCM_MAX_CHANNEL_NAME_LENGTH + 1];
  snprintf(channel, sizeof channel, "%s_DRIVE", argv[3]);
  chequer_state me, goal;
  while (leader != NULL && follower != NULL) {
    example_drive_t drive = {0, 0}; /* stands still unless both are seen */
    if (chequer_new(follower, &me, 200) && chequer_latest(leader, &goal) && goal.since_seen_us < 500000) {
      const double dx = goal.position[0] - me.position[0], dy = goal.position[1] - me.position[1];
      const double off_course = remainder(atan2(dy, dx) - me.heading, 2 * M_PI);
      drive.speed = clamp(1.5 * (hypot(dx, dy) - 0.3) * fmax(0, cos(off_course)), 0, 0.5);
      drive.yaw_rate = clamp(3 * off_course, -2, 2);
    }
    example_drive_t_publish(chequer_lcm(client), channel, &drive);
  }
  chequer_close(client);
  return 1;
}
