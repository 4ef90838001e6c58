"""A client of chequerd to copy into programs of your own.

Needs the Python that chequer_lcm_gen.py makes of chequer's lcmtypes (it is installed as .../lcmtypes/python) on
PYTHONPATH. Where the module lcm is not installed (Debian has no package of it), lcm_udp.py beside this file does for it.
"""

import sys
import threading

import chequer
import lcm_log

try:
    import lcm
except ImportError:
    import lcm_udp as lcm


class Target:
    """What arrives of one robot or marker: the latest, the new, the next. Any thread."""

    def __init__(self, client):
        self._client = client
        self._changed = threading.Condition()
        self._value = None
        self._arrived = 0  # values so far
        self._given = 0  # of them, the last one that was asked for

    def latest(self):
        """What came last; None before the first. Does not wait."""
        with self._changed:
            self._given = self._arrived
            return self._value

    def new(self, timeout):
        """What was not asked for yet: at once if there is such, else when it comes. None after `timeout` seconds."""
        return self._wait_beyond(self._given, timeout)

    def next(self, timeout):
        """What arrives after the call. None after `timeout` seconds."""
        return self._wait_beyond(self._arrived, timeout)

    def put(self, value):
        """For the client: something arrived."""
        with self._changed:
            self._value = value
            self._arrived += 1
            self._changed.notify_all()

    def _wait_beyond(self, count, timeout):
        if self._client.log is not None:
            # A log does not come by itself: it is read until it has something, and its end is the end of waiting.
            while self._arrived <= count:
                if not self._client.read_one():
                    return None
        with self._changed:
            if not self._changed.wait_for(lambda: self._arrived > count, timeout):
                return None
            self._given = self._arrived
            return self._value


class Client:
    """Listens to one daemon: live on a thread of its own, or to a log."""

    def __init__(self, prefix, url="", log=None):
        """prefix: of the daemon's channels, such as CHEQUER_ceiling. url: of LCM; empty: LCM_DEFAULT_URL, else LCM's
        default. log: an LCM log to read instead of live messages."""
        self._prefix = prefix
        self._tracks = {}  # targets by the name of the robot
        self._markers = {}  # targets by the marker's id
        self.log = None
        if log is not None:
            self.log = lcm_log.events(log)
            return
        self.lcm = lcm.LCM(url) if url else lcm.LCM()
        for suffix in ("_TRACKS", "_POSES"):
            self.lcm.subscribe(prefix + suffix, self._on_message)
        threading.Thread(target=self._listen, daemon=True).start()

    def track(self, robot):
        """The track of a robot of the roster: chequer.track_t."""
        return self._tracks.setdefault(robot, Target(self))

    def marker(self, marker_id):
        """The raw pose of a marker: chequer.marker_pose_t."""
        return self._markers.setdefault(marker_id, Target(self))

    def publish(self, channel, message):
        """Sends a message; nothing happens where a log is read."""
        if self.log is None:
            self.lcm.publish(channel, message.encode())

    def read_one(self):
        """Takes one event of the log; False at its end."""
        for _, channel, data in self.log:
            self._on_message(channel, data)
            return True
        return False

    def _listen(self):
        while True:
            self.lcm.handle()

    def _on_message(self, channel, data):
        try:
            if channel == self._prefix + "_TRACKS":
                for track in chequer.tracks_t.decode(data).tracks:
                    if track.name in self._tracks:
                        self._tracks[track.name].put(track)
            elif channel == self._prefix + "_POSES":
                for marker in chequer.poses_t.decode(data).markers:
                    marker_id = marker.id & 0xFFFFFFFFFFFFFFFF
                    if marker.id_valid and marker_id in self._markers:
                        self._markers[marker_id].put(marker)
        except ValueError as error:  # another version of the type, or a message that is not what it says
            print(f"{channel}: {error}", file=sys.stderr)
