#!/bin/bash
# Checks `make bench-robust`, on three drawn machines.
. tests/bench/check_lib
# Makes one word of each row's name, and keeps the cells.
margins() { "$BUILD/tests/bench/robust" margins 3 | awk -F '|' '/^hexid/ { print } /^\| (stated|wide)/ { gsub(/[^A-Za-z]+/, "_", $2); print $2, $3, $4, $5, $6, $7 }'; }
claim "make bench-robust predicts margins, shipped and tuned" table 5 "_stated_shipped_gain_margin_dB_ _wide_tuned_phase_margin_degrees_" margins
again() { diff <("$BUILD/tests/bench/robust" wide 16 | head -n 2) <("$BUILD/tests/bench/robust" wide 16 | head -n 2); }
claim "a machine is drawn again by its number" again
