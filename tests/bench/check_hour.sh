#!/bin/bash
# Checks `make bench-hour` with two minutes instead of an hour.
. tests/bench/check_lib
export SECONDS_OF=120
claim "make bench-hour measures time and memory" tests/bench/hour.sh "$BUILD" "$VENV/bin/python"
mkdir -p "$work/b" && cp "$work/empty/hexid" "$work/b/hexid"
claim "a hexid that does nothing is no row" fails tests/bench/hour.sh "$work/b" "$VENV/bin/python"
