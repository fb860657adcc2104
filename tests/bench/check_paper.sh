#!/bin/bash
# Checks `make bench-paper`.
. tests/bench/check_lib
entries="mx my mz Ixx Iyy Izz Mt15 Mt24 Mt42 Mt51"
paper() {
    "$BUILD/tests/bench/paper" "$1" tests/data tests/ident/least_squares.py "$work/paper" sim.engine=closed_form motion.park_z_m=0.35 motion.rate_mps=0.55 motion.engage_s=1.6 \
        motion.park_s=1.6 motion.hold_s=0.1 tests.settle_s=0.5 tests.ramp_s=0.3 tests.duration_s=2 tests.ramp_out_s=0.2 2>"$work/progress" ||
        { tail -n 3 "$work/progress"; return 1; }
}
claim "make bench-paper runs" paper "$hexid"
for name in table3 table4; do
    claim "its $name has every entry" tests/bench/measured.py "$work/paper/$name.csv" 16 $entries
done
claim "its table of dry friction has every step" tests/bench/measured.py "$work/paper/tableC1.csv" 12 $(seq 20 20 200)
for name in method_c least_squares wavelet; do
    claim "its table of $name has every step" tests/bench/measured.py "$work/paper/$name.csv" 10 $(seq 0 20 200)
done
claim "a hexid that does nothing is no table" fails paper "$work/empty/hexid"
