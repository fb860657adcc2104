#!/bin/bash
# Checks `make bench-gap` on one effect.
. tests/bench/check_lib
scorecard() { # with BUILD's hexid
    mkdir -p "$work/b/tests/bench"
    ln -sf "$1" "$work/b/hexid"
    ln -sf "$(realpath "$BUILD/tests/bench/signatures")" "$work/b/tests/bench/signatures"
    EFFECTS=valve_null_bias KINDS=single SIZES=typical SUBSTEPS=8 tests/gap/bench.sh "$work/b"
}
claim "make bench-gap draws a case, runs it and scores it" table 0 "" scorecard "$hexid"
claim "its figures are there" tests/bench/measured.py "$work/table" 3 "held-out gap over the noise floor" "    error over what was hidden"
claim "its lines say the build, and the case" tests/bench/measured.py "$work/b/gap_score/score.csv" 10 valve_null_bias
claim "its page says the build" grep -qF "$("$hexid" --version)" "$work/b/gap_score/report.html"
claim "a hexid that does nothing is no scorecard" fails scorecard "$work/empty/hexid"
claim "nor is a scorecard of no case" fails env EFFECTS=no_such_effect KINDS=single tests/gap/bench.sh "$work/b"
