#!/bin/bash
# Checks `make bench-friction` and `make bench-springs` on the independent rig.
. tests/bench/check_lib
friction() { python3 tests/ident/rig_friction.py --seeds "$1" --case coulomb_100; }
claim "make bench-friction has its case with every figure" table 8 coulomb_100 friction 1
claim "a hexid that does nothing is no figure" fails env HEXID="$work/empty/hexid" python3 tests/ident/rig_friction.py --seeds 1 --case none
springs() { python3 tests/ident/rig_springs.py --seeds "$1"; }
claim "make bench-springs has every axis" table 5 "x y z phi theta psi" springs 1
claim "no seed is no table" fails springs 0
