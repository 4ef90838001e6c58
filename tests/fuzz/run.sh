#!/bin/bash
# Runs each fuzz target of a build for a while: tests/fuzz/run.sh BUILD_DIR [SECONDS] [TARGET…]
# What breaks one is kept in BUILD_DIR/fuzz/found. Status 0 only if nothing did.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

[[ $# -ge 1 && -d $1/fuzz ]] || {
  printf 'usage: %s BUILD_DIR [SECONDS] [TARGET...]; BUILD_DIR must have been built with -DCHEQUER_BUILD_FUZZERS=ON\n' "$0" >&2
  exit 2
}
build=$(cd "$1" && pwd)
seconds=${2:-20}
targets=("${@:3}")
if [[ ${#targets[@]} -eq 0 ]]; then
  for binary in "$build"/fuzz/fuzz_*; do targets+=("$(basename "$binary" | sed 's/^fuzz_//')"); done
  targets+=(lcm_python)
fi

mkdir -p "$build/fuzz/found"
status=0
for target in "${targets[@]}"; do
  # New inputs go to the first folder, which is the build's; the seeds stay as they are.
  mkdir -p "$build/fuzz/corpus/$target"
  printf '%s: %s s\n' "$target" "$seconds"
  log=$build/fuzz/$target.log
  if [[ $target == lcm_python ]]; then
    # No library is instrumented for it: what breaks a decoder is printed.
    if python3 "$here/python_types.py" "$build/lcmtypes/python" "$seconds" >"$log" 2>&1; then tail -n 1 "$log"; else
      cat "$log"
      status=1
    fi
    continue
  fi
  if "$build/fuzz/fuzz_$target" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -max_len=65536 \
    -artifact_prefix="$build/fuzz/found/$target-" "$build/fuzz/corpus/$target" "$here/corpus/$target" >"$log" 2>&1; then
    tail -n 1 "$log"
  else
    grep -vE '^#|NEW_FUNC|^0x' "$log" | tail -n 40
    printf '%s: FAILED; the input is in %s\n' "$target" "$build/fuzz/found" >&2
    status=1
  fi
done
exit $status
