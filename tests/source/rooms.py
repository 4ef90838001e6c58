#!/usr/bin/env python3
"""Holds the detector's rooms against the table of their README: `rooms.py src/detect`.

Each row of the table that begins with a folder names the headers to enter it by. A file may include those, what `common/`
has, and what lies in its own folder; `common/` knows no room, and no room knows what lies beside the folders, but the
detector itself. Other modules include `toolbox.h` alone. Status 1, with a line for each, if an #include does otherwise.
"""
import pathlib
import re
import sys

TOOLBOX = "toolbox.h"
INCLUDE = re.compile(r'^#include "detect/([^"]+)"', re.M)


def entrances_in(readme):
    """Folder -> headers to enter it by."""
    rows = re.findall(r"^\| `(\w+)/` \| ([^|]*) \|", readme, re.M)
    return {room: set(re.findall(r"`([\w.-]+\.h)`", headers)) for room, headers in rows}


def fault_of(room, included, entrances):
    """Why a file of `room` (empty: of no room) may not include that; empty if it may."""
    to, _, header = included.rpartition("/")
    if to == room:
        return ""
    if to not in entrances:
        return "lies beside the rooms" if room else f"{to}/ is not in the README's table"
    if room == "common":
        return "common/ knows no room"
    if to != "common" and header not in entrances[to]:
        return f"{to}/ is entered by {', '.join(sorted(entrances[to]))}"
    return ""


def main(folder):
    entrances = entrances_in((folder / "README.md").read_text())
    if len(entrances) < 2:
        sys.exit(f"{folder}/README.md: no table of rooms")
    faults = []
    for path in sorted(folder.rglob("*")):
        if path.suffix not in (".h", ".cpp"):
            continue
        room = str(path.parent.relative_to(folder)).removeprefix(".")
        if room and room not in entrances:
            faults.append(f"{path}: {room}/ is not in the README's table")
        for included in INCLUDE.findall(path.read_text()):
            if fault := fault_of(room, included, entrances):
                faults.append(f'{path}: "detect/{included}": {fault}')
    for path in sorted(folder.parent.rglob("*")):
        if path.suffix in (".h", ".cpp") and folder not in path.parents:
            faults += [f'{path}: "detect/{included}": other modules include detect/{TOOLBOX}'
                       for included in INCLUDE.findall(path.read_text()) if included != TOOLBOX]
    for room, headers in entrances.items():
        faults += [f"{folder}/README.md: {room}/{header} is not there" for header in sorted(headers)
                   if not (folder / room / header).exists()]
    print("\n".join(faults) or f"{len(entrances)} rooms, entered as their README says")
    return 1 if faults else 0


def self_test():
    table = "| `common/` | any | shared |\n| `fit/` | `fit.h` | x |\n| `boards/` | `anchor.h`, `twins.h` | y |\n"
    entrances = entrances_in(table)
    assert entrances == {"common": set(), "fit": {"fit.h"}, "boards": {"anchor.h", "twins.h"}}, entrances
    for room, included, bad in [("fit", "fit/inner.h", False), ("boards", "fit/fit.h", False),
                                ("boards", "fit/inner.h", True), ("fit", "common/light.h", False),
                                ("common", "fit/fit.h", True), ("fit", "tracer.h", True), ("", "tracer.h", False),
                                ("", "attic/old.h", True)]:
        assert bool(fault_of(room, included, entrances)) == bad, (room, included)


if __name__ == "__main__":
    self_test()
    sys.exit(main(pathlib.Path(sys.argv[1])))
