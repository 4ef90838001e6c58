"""python_types.py FOLDER [SECONDS] [SEED]: gives the Python decoders in FOLDER (that chequer_lcm_gen.py wrote) messages that
are cut, changed and joined by chance, for a while. They must either give a message or raise ValueError, at once and
without taking memory. Status 1 where one does not; it prints the bytes then, and the seed always."""

import importlib
import os
import random
import resource
import sys
import time

TYPES = ["count_t", "marker_pose_t", "poses_t", "robot_pose_t", "robots_t", "stage_latency_t", "status_t", "track_t",
         "tracks_t", "ask_t", "camera_family_t", "camera_t", "detail_cell_t", "detail_t", "preview_t",
         "calibration_reference_t", "calibration_t"]
MEMORY = 1 << 30
NUMBERS = [b"\xff\xff\xff\xff", b"\x80\0\0\0", b"\x7f\xff\xff\xff", b"\0\0\0\0", b"\0\0\0\1", b"\0\1\0\0", b"\xff", b"\0"]


def sample(chequer, name, rng):
    """A whole message, with some elements in each of its lists."""
    message = getattr(chequer, name)()
    for field in message.__slots__:
        value = getattr(message, field)
        if isinstance(value, str):
            setattr(message, field, "x" * rng.randrange(20))
    elements = {"poses_t": [("marker_count", "markers", "marker_pose_t")],
                "robots_t": [("robot_count", "robots", "robot_pose_t")],
                "tracks_t": [("track_count", "tracks", "track_t")],
                "status_t": [("drop_count", "drops", "count_t"), ("stage_count", "stages", "stage_latency_t"),
                             ("detection_count", "detections", "count_t")]}
    if name == "preview_t":  # LCM's own default for bytes is a text, which it cannot send
        message.jpeg, message.jpeg_bytes = b"x" * 9, 9
    elements["camera_t"] = [("family_count", "families", "camera_family_t")]
    elements["calibration_t"] = [("reference_count", "references", "calibration_reference_t")]
    elements["detail_t"] = [("cell_count", "cells", "detail_cell_t")]
    for count, field, element in elements.get(name, []):
        setattr(message, field, [sample(chequer, element, rng) for _ in range(rng.randrange(4))])
        setattr(message, count, len(getattr(message, field)))
    return message


def mutate(data, rng):
    data = bytearray(data)
    for _ in range(rng.randrange(4)):
        at = rng.randrange(8, len(data) + 1) if len(data) > 8 else len(data)
        kind = rng.randrange(4)
        if kind == 0:
            del data[at:]
        elif kind == 1:
            data[at:at + rng.randrange(9)] = rng.randbytes(rng.randrange(9))
        elif kind == 2:
            number = rng.choice(NUMBERS)
            data[at:at + len(number)] = number
        else:
            data[at:at] = data[8:rng.randrange(8, len(data) + 1)] if len(data) > 8 else b""
    return bytes(data)


def main():
    sys.dont_write_bytecode = True
    sys.path.insert(0, sys.argv[1])
    chequer = importlib.import_module("chequer")
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 10
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else int.from_bytes(os.urandom(4), "big")
    print(f"seed {seed}", flush=True)
    rng = random.Random(seed)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    runs = understood = 0
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        name = rng.choice(TYPES)
        data = mutate(sample(chequer, name, rng).encode(), rng)
        began = time.monotonic()
        try:
            getattr(chequer, name).decode(data).encode()
            understood += 1
        except ValueError:
            pass
        except BaseException as problem:
            sys.exit(f"{name}: {problem!r} of {data.hex()}")
        if time.monotonic() - began > 1:
            sys.exit(f"{name}: took {time.monotonic() - began:.1f} s: {data.hex()}")
        runs += 1
    if understood == 0 or understood == runs:
        sys.exit(f"{understood} of {runs} were understood: nothing was tried")
    print(f"{runs} messages, {understood} of them understood")


if __name__ == "__main__":
    main()
