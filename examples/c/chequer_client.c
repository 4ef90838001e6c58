#include "chequer_client.h"

#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "chequer_poses_t.h"
#include "chequer_tracks_t.h"

struct chequer_target {
  struct chequer_client* client;
  struct chequer_target* next;
  char* robot; /* NULL: a marker */
  uint64_t id;
  chequer_state state;
  uint64_t arrived; /* values so far */
  uint64_t given;   /* of them, the last one that was asked for */
};

struct chequer_client {
  lcm_t* lcm;
  pthread_t thread;
  pthread_mutex_t mutex; /* guards all below, and the targets */
  pthread_cond_t changed;
  struct chequer_target* targets;
  int stopping;
};

static double heading_of(const double* q) {
  return atan2(2 * (q[1] * q[2] + q[0] * q[3]), 1 - 2 * (q[2] * q[2] + q[3] * q[3]));
}

/* Under the mutex. */
static void put(struct chequer_target* target, const chequer_state* state) {
  target->state = *state;
  ++target->arrived;
  pthread_cond_broadcast(&target->client->changed);
}

static void on_tracks(const lcm_recv_buf_t* buffer, const char* channel, const chequer_tracks_t* message, void* user) {
  (void)buffer;
  (void)channel;
  chequer_client* client = user;
  pthread_mutex_lock(&client->mutex);
  for (int32_t i = 0; i < message->track_count; ++i) {
    const chequer_track_t* track = &message->tracks[i];
    chequer_state state = {.time_utc_us = message->valid_utc_us,
                           .heading = track->heading,
                           .yaw_rate = track->angular_velocity[2],
                           .since_seen_us = track->since_seen_us};
    memcpy(state.position, track->position, sizeof state.position);
    memcpy(state.orientation, track->orientation, sizeof state.orientation);
    memcpy(state.velocity, track->velocity, sizeof state.velocity);
    for (struct chequer_target* target = client->targets; target != NULL; target = target->next)
      if (target->robot != NULL && strcmp(target->robot, track->name) == 0) put(target, &state);
  }
  pthread_mutex_unlock(&client->mutex);
}

static void on_poses(const lcm_recv_buf_t* buffer, const char* channel, const chequer_poses_t* message, void* user) {
  (void)buffer;
  (void)channel;
  chequer_client* client = user;
  pthread_mutex_lock(&client->mutex);
  for (int32_t i = 0; i < message->marker_count; ++i) {
    const chequer_marker_pose_t* marker = &message->markers[i];
    if (!marker->id_valid || !marker->pose_valid) continue;
    chequer_state state = {.time_utc_us = message->capture_utc_us, .heading = heading_of(marker->orientation)};
    memcpy(state.position, marker->position, sizeof state.position);
    memcpy(state.orientation, marker->orientation, sizeof state.orientation);
    for (struct chequer_target* target = client->targets; target != NULL; target = target->next)
      if (target->robot == NULL && target->id == (uint64_t)marker->id) put(target, &state);
  }
  pthread_mutex_unlock(&client->mutex);
}

static void* listen_on(void* user) {
  chequer_client* client = user;
  for (;;) {
    pthread_mutex_lock(&client->mutex);
    const int stopping = client->stopping;
    pthread_mutex_unlock(&client->mutex);
    if (stopping || lcm_handle_timeout(client->lcm, 100) < 0) return NULL;
  }
}

static int subscribe(chequer_client* client, const char* prefix) {
  char* channel = malloc(strlen(prefix) + sizeof "_TRACKS");
  if (channel == NULL) return 0;
  strcat(strcpy(channel, prefix), "_TRACKS");
  const int tracks = chequer_tracks_t_subscribe(client->lcm, channel, on_tracks, client) != NULL;
  strcat(strcpy(channel, prefix), "_POSES");
  const int poses = chequer_poses_t_subscribe(client->lcm, channel, on_poses, client) != NULL;
  free(channel);
  return tracks && poses;
}

chequer_client* chequer_open(const char* prefix, const char* url) {
  chequer_client* client = calloc(1, sizeof *client);
  if (client == NULL) return NULL;
  client->lcm = lcm_create(url);
  if (client->lcm == NULL || !subscribe(client, prefix)) {
    if (client->lcm != NULL) lcm_destroy(client->lcm);
    free(client);
    return NULL;
  }
  pthread_mutex_init(&client->mutex, NULL);
  pthread_condattr_t monotonic; /* so that nobody who sets the clock changes a time-out */
  pthread_condattr_init(&monotonic);
  pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
  pthread_cond_init(&client->changed, &monotonic);
  pthread_condattr_destroy(&monotonic);
  if (pthread_create(&client->thread, NULL, listen_on, client) != 0) {
    lcm_destroy(client->lcm);
    free(client);
    return NULL;
  }
  return client;
}

void chequer_close(chequer_client* client) {
  pthread_mutex_lock(&client->mutex);
  client->stopping = 1;
  pthread_mutex_unlock(&client->mutex);
  pthread_join(client->thread, NULL);
  lcm_destroy(client->lcm);
  while (client->targets != NULL) {
    struct chequer_target* target = client->targets;
    client->targets = target->next;
    free(target->robot);
    free(target);
  }
  pthread_cond_destroy(&client->changed);
  pthread_mutex_destroy(&client->mutex);
  free(client);
}

static chequer_target* watch(chequer_client* client, char* robot, uint64_t id) {
  struct chequer_target* target = calloc(1, sizeof *target);
  if (target == NULL) return NULL;
  target->client = client;
  target->robot = robot;
  target->id = id;
  pthread_mutex_lock(&client->mutex);
  target->next = client->targets;
  client->targets = target;
  pthread_mutex_unlock(&client->mutex);
  return target;
}

chequer_target* chequer_watch_track(chequer_client* client, const char* robot) {
  char* name = strdup(robot);
  chequer_target* target = name != NULL ? watch(client, name, 0) : NULL;
  if (target == NULL) free(name);
  return target;
}

chequer_target* chequer_watch_marker(chequer_client* client, uint64_t id) { return watch(client, NULL, id); }

/* Under the mutex: waits until more than `count` values arrived. */
static int wait_beyond(chequer_target* target, uint64_t count, int timeout_ms, chequer_state* state) {
  struct timespec end;
  clock_gettime(CLOCK_MONOTONIC, &end);
  end.tv_sec += timeout_ms / 1000;
  end.tv_nsec += timeout_ms % 1000 * 1000000L;
  if (end.tv_nsec >= 1000000000L) {
    end.tv_nsec -= 1000000000L;
    ++end.tv_sec;
  }
  while (target->arrived <= count)
    if (pthread_cond_timedwait(&target->client->changed, &target->client->mutex, &end) == ETIMEDOUT) return 0;
  target->given = target->arrived;
  *state = target->state;
  return 1;
}

int chequer_latest(chequer_target* target, chequer_state* state) {
  pthread_mutex_lock(&target->client->mutex);
  const int known = target->arrived > 0;
  target->given = target->arrived;
  if (known) *state = target->state;
  pthread_mutex_unlock(&target->client->mutex);
  return known;
}

int chequer_new(chequer_target* target, chequer_state* state, int timeout_ms) {
  pthread_mutex_lock(&target->client->mutex);
  const int known = wait_beyond(target, target->given, timeout_ms, state);
  pthread_mutex_unlock(&target->client->mutex);
  return known;
}

int chequer_next(chequer_target* target, chequer_state* state, int timeout_ms) {
  pthread_mutex_lock(&target->client->mutex);
  const int known = wait_beyond(target, target->arrived, timeout_ms, state);
  pthread_mutex_unlock(&target->client->mutex);
  return known;
}

lcm_t* chequer_lcm(chequer_client* client) { return client->lcm; }
