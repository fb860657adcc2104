#!/bin/bash
# Checks `make bench-friction`, `make bench-springs` and `make bench-sensors` on the independent rig.
. tests/bench/check_lib
friction() { python3 tests/ident/rig_friction.py --seeds "$1" --case coulomb_100; }
claim "make bench-friction has its case with every figure" table 8 coulomb_100 friction 1
claim "a hexid that does nothing is no figure" fails env HEXID="$work/empty/hexid" python3 tests/ident/rig_friction.py --seeds 1 --case none
springs() { python3 tests/ident/rig_springs.py --seeds "$1"; }
claim "make bench-springs has every axis" table 5 "x y z phi theta psi" springs 1
claim "no seed is no table" fails springs 0
sensors() { python3 tests/ident/real_sensors.py --machines "$1" --row as_modelled --recordings "$work/sensors"; }
claim "make bench-sensors has its row with every figure" table 6 as_modelled sensors 1
claim "no machine is no table" fails sensors 0
faults() { tests/ident/random_faults.py --recordings "$work/sensors" --row as_modelled --machines 1 --faults "$1"; }
claim "make bench-faults counts its draws" faults 6
claim "no fault is no figure" fails faults 0
claim "nor is a hexid that does nothing" fails env HEXID="$work/empty/hexid" python3 tests/ident/real_sensors.py --machines 1 --row as_modelled
