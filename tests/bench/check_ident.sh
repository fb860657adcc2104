#!/bin/bash
# Checks `make bench-methods` and `make bench-coverage`.
. tests/bench/check_lib
methods() { tests/ident/compare.py --dry "$1" --seeds 0; }
claim "make bench-methods has every method and entry" table 10 "method_a method_b method_c least_squares wavelet" methods 100
claim "a hexid that does nothing is no comparison" fails env HEXID="$work/empty/hexid" tests/ident/compare.py --dry 100 --seeds 0
coverage() { python3 tests/ident/coverage.py --machines "$@"; }
claim "make bench-coverage has every axis and the payload" table 6 "x y z phi theta psi" coverage 3
claim "what it says of all intervals is there" tests/bench/measured.py "$work/table" 2 "all:" "payload, mass, %:" "payload, centre, mm:"
claim "no machine is no coverage" fails coverage 0
claim "nor is a hexid that does nothing" fails env HEXID="$work/empty/hexid" python3 tests/ident/coverage.py --machines 1
