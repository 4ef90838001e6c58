"""watch.py PREFIX ROBOT|ID [LOG]: prints a robot's track, or a marker's pose where a number is given, as it comes, or from
an LCM log; until nothing came for five seconds, or the log is over."""

import math
import sys

from chequer_client import Client


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit("usage: watch.py PREFIX ROBOT|ID [LOG], such as: watch.py CHEQUER_ceiling alice")
    prefix, who = sys.argv[1:3]
    client = Client(prefix, log=sys.argv[3] if len(sys.argv) == 4 else None)
    is_marker = who.isdigit()
    target = client.marker(int(who)) if is_marker else client.track(who)
    print(f"watching {who}", file=sys.stderr, flush=True)
    seen = False
    while value := target.new(timeout=5):
        seen = True
        text = f"{who} {value.position[0]:.4f} {value.position[1]:.4f} m"
        if not is_marker:
            speed = math.hypot(value.velocity[0], value.velocity[1])
            text += f", heading {value.heading:.4f} rad, {speed:.4f} m/s, {value.angular_velocity[2]:.4f} rad/s"
        print(text, flush=True)
    sys.exit(0 if seen else f"nothing of {who} came")


if __name__ == "__main__":
    try:
        main()
    except (RuntimeError, OSError, ValueError) as problem:
        sys.exit(f"watch.py: {problem}")
