#ifndef CHEQUER_CLIENT_H
#define CHEQUER_CLIENT_H

#include <lcm/lcm.h>
#include <stdint.h>

/* A client of chequerd in C, to copy into programs of your own. Needs LCM and the C that chequer_lcm_gen.py makes of
   chequer's lcmtypes, whose decoders refuse messages that lie about their length. Every function may be called from any
   thread. */

typedef struct chequer_client chequer_client;
typedef struct chequer_target chequer_target;

/* A robot (of its track) or a marker (of its raw pose). */
typedef struct {
  int64_t time_utc_us;   /* for which it holds, microseconds of UTC since 1970 */
  double position[3];    /* metres, in the frame of reference that the daemon publishes in */
  double orientation[4]; /* w x y z */
  double heading;        /* rad */
  double velocity[3];    /* m/s; of a marker 0 */
  double yaw_rate;       /* rad/s; of a marker 0 */
  int64_t since_seen_us; /* of a track: since its last pose; of a marker 0 */
} chequer_state;

/* prefix: of the daemon's channels, such as CHEQUER_ceiling. url: of LCM; NULL: LCM_DEFAULT_URL, else LCM's default.
   NULL where LCM cannot be opened (no multicast route) or there is no memory. */
chequer_client* chequer_open(const char* prefix, const char* url);
void chequer_close(chequer_client* client);

/* What is watched is there as long as the client. NULL where there is no memory. */
chequer_target* chequer_watch_track(chequer_client* client, const char* robot);
chequer_target* chequer_watch_marker(chequer_client* client, uint64_t id);

/* Each fills *state and returns 1, or returns 0.
   latest: what came last; 0 before the first. Does not wait.
   new: what was not asked for yet, at once if there is such, else when it comes; 0 after the time.
   next: what arrives after the call; 0 after the time. */
int chequer_latest(chequer_target* target, chequer_state* state);
int chequer_new(chequer_target* target, chequer_state* state, int timeout_ms);
int chequer_next(chequer_target* target, chequer_state* state, int timeout_ms);

/* For sending. */
lcm_t* chequer_lcm(chequer_client* client);

#endif
