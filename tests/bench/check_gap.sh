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
claim "and how often verdicts of a certainty are true" grep -q '^all  *0.99 to 1  *1 .* 100.0 %' "$work/table"
claim "the page draws that" grep -q "<title>1 verdicts from 0.99 to 1</title>" "$work/b/gap_score/report.html"
claim "its page says the build" grep -qF "$("$hexid" --version)" "$work/b/gap_score/report.html"
claim "a hexid that does nothing is no scorecard" fails scorecard "$work/empty/hexid"
claim "nor is a scorecard of no case" fails env EFFECTS=no_such_effect KINDS=single tests/gap/bench.sh "$work/b"
