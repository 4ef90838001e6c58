#!/usr/bin/env python3
"""Names what opens files for reading by itself: `file_reading.py FOLDER...`.

A file that a configuration or a command line names is opened by OpenForReading or ReadFile (core/file.h), which never
wait for a pipe or a device. Status 1 if anything else opens one.
"""
import pathlib
import re
import sys

OPENS = re.compile(r"\bifstream\b|\bimread\s*\(|\bparse_file\s*\(|\bfopen\s*\([^)]*,\s*\"r|\bopen\s*\([^)]*O_RDONLY")
ALLOWED = {
    "core/file.cpp": "the one place",
    "capture/v4l2_nodes.cpp": "the kernel's own files, which always answer",
}


def main():
    files = [file for folder in sys.argv[1:] for file in sorted(pathlib.Path(folder).rglob("*")) if file.suffix in (".h", ".cpp")]
    bad = [f"{file}:{number}: {line.strip()}: opens a file without core/file.h"
           for file in files if not any(str(file).endswith(name) for name in ALLOWED)
           for number, line in enumerate(file.read_text().split("\n"), 1) if OPENS.search(line)]
    if not files or not OPENS.search("std::ifstream file(path);"):
        sys.exit("file_reading.py: nothing was looked at")
    print("\n".join(bad) if bad else f"{len(files)} files: every file that is read is opened in one place")
    sys.exit(1 if bad else 0)


main()
