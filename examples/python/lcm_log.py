"""Reads LCM logs (of lcm-logger, or of chequerd with a file:// URL) without the lcm module."""

import struct

SYNC = 0xEDA1DA01
HEADER = struct.Struct(">IqqII")  # sync word, event number, time in microseconds, lengths of channel and data


def events(path):
    """Gives (time in microseconds of UTC, channel, data) of each event. Raises ValueError where the log is damaged."""
    with open(path, "rb") as log:
        while header := log.read(HEADER.size):
            if len(header) < HEADER.size:
                raise ValueError(f"{path} is cut off")
            sync, _, time_us, channel_length, data_length = HEADER.unpack(header)
            if sync != SYNC or channel_length > 1000:
                raise ValueError(f"{path} is no LCM log, or damaged at byte {log.tell() - HEADER.size}")
            channel = log.read(channel_length)
            data = log.read(data_length)
            if len(data) < data_length:
                raise ValueError(f"{path} is cut off")
            yield time_us, channel.decode("utf-8", "replace"), data
