#!/bin/bash
# Checks `make bench-table5` on two hypotheses.
. tests/bench/check_lib
search() { "$python" tests/paper/table5.py search --cache "$work/$1" --noisy 3 --effects 1 --only "${2:-dry friction}" --only "mass centre x"; }
rows() { sed 's/^| //' "$work/table" >"$work/rows" && tests/bench/measured.py "$work/rows" 13 nothing "dry friction" "mass centre x"; }
claim "make bench-table5 prints the hypotheses, fitted" table 0 "" search a
claim "each row has every figure" rows
claim "a hypothesis that is none is no search" fails search a nonsense
claim "nor is a hexid that does nothing" fails env HEXID="$work/empty/hexid" "$python" tests/paper/table5.py search --cache "$work/b" --noisy 2
