#!/bin/bash
# docs/table5.md states the simulated machine's readings with certain effects: those machines are run again.
. tests/scenarios/lib

export HEXID=$hexid
claim "docs/table5.md: each machine reads what the page says, to 0.2 (kg, kg m, kg m^2)" \
    "$python" tests/paper/table5.py check --cache "$work" docs/table5.md
changed() {
    sed '/simulated, A/s/[-0-9.]*$/99.9/' docs/table5.md >"$work/wrong.md"
    "$python" tests/paper/table5.py check --cache "$work" "$work/wrong.md" && return 1
    return 0
} >"$work/changed"
refuted() { changed && grep "largest difference" "$work/changed"; }
claim "a page with another number is not taken" refuted
