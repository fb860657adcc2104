#!/bin/bash
# Checks `make bench-trajectories`, on the first two seconds of two motions and without dry friction.
. tests/bench/check_lib
tests/bench/motions.py "$work/motions"
for motion in earthquake circle; do head -n 202 "$work/motions/$motion.csv" >"$work/$motion.csv"; done
# Makes one word of each row's name, and keeps the cells.
rows() {
    "$BUILD/tests/bench/trajectories" -s "$work"/{earthquake,circle}.csv |
        awk -F '|' '/^hexid/ { print } /^\| (PID|model)/ { gsub(/[^A-Za-z]+/, "_", $2); print $2, $3, $4 }'
}
claim "make bench-trajectories measures both laws" table 8 \
    "_PID_as_shipped_ _PID_as_tune_sets_it_ _model_payload_too_light_ _model_as_identify_model_wrote_it_ _model_the_truth_" rows
printf 't_s,x_m\n0,0\n0.1,0.5\n0.2,0\n' >"$work/jump.csv"
claim "a trajectory beyond the machine's limits ends it with an error" fails "$BUILD/tests/bench/trajectories" -s "$work/jump.csv"
