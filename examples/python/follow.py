"""follow.py PREFIX LEADER FOLLOWER [LOG]: drives one robot after another, 0.3 m behind it, by their tracks. With an LCM
log it prints what it would have sent."""

import math
import sys

from chequer_client import Client
from example import drive_t


def steer(me, goal):
    drive = drive_t()  # stands still unless both are seen
    if me and goal and goal.since_seen_us < 500_000:
        dx, dy = goal.position[0] - me.position[0], goal.position[1] - me.position[1]
        off_course = math.remainder(math.atan2(dy, dx) - me.heading, 2 * math.pi)
        drive.speed = min(max(1.5 * (math.hypot(dx, dy) - 0.3) * max(0, math.cos(off_course)), 0.0), 0.5)
        drive.yaw_rate = min(max(3 * off_course, -2.0), 2.0)
    return drive


def main():
    if len(sys.argv) not in (4, 5):
        sys.exit("usage: follow.py PREFIX LEADER FOLLOWER [LOG]")
    client = Client(sys.argv[1], log=sys.argv[4] if len(sys.argv) == 5 else None)
    leader, follower = client.track(sys.argv[2]), client.track(sys.argv[3])
    while (me := follower.new(timeout=0.2)) or client.log is None:
        drive = steer(me, leader.latest())
        client.publish(sys.argv[3] + "_DRIVE", drive)
        if client.log is not None:
            print(f"{drive.speed:.3f} m/s {drive.yaw_rate:.3f} rad/s")


if __name__ == "__main__":
    try:
        main()
    except (RuntimeError, OSError, ValueError) as problem:
        sys.exit(f"follow.py: {problem}")
