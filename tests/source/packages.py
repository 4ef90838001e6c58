#!/usr/bin/env python3
"""packages.py FILE: whether scripts/packages is what scripts/setup reads: parts run, build and test, each package once, in
the order of the alphabet; and that what only tests need is not fetched before the first pose."""
import re
import sys

parts = {}
part = None
for number, line in enumerate(open(sys.argv[1], encoding="utf-8"), 1):
    line = line.split("#")[0].strip()
    if not line:
        continue
    if match := re.fullmatch(r"\[(\w+)\]", line):
        part = parts.setdefault(match[1], [])
    elif part is None or not re.fullmatch(r"[a-z0-9][a-z0-9+.-]+", line):
        sys.exit(f"{sys.argv[1]}:{number}: '{line}' is no package of a part")
    else:
        part.append(line)

assert list(parts) == ["run", "build", "test"], list(parts)
for name, packages in parts.items():
    assert packages and packages == sorted(packages), f"[{name}] is not in order: {packages}"
every = [package for packages in parts.values() for package in packages]
assert len(every) == len(set(every)), "a package is named twice"
for package in every:
    only_tests = re.match(r"clang|valgrind|qemu|lintian|libgtest|libgmock|libbenchmark|busybox", package)
    assert not only_tests or package in parts["test"], f"{package} is for tests"
