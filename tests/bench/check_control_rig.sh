#!/bin/bash
# Checks `make bench-control-rig`, at one frequency and with the configured base.
. tests/bench/check_lib
# Makes one word of each row's name, and keeps the cells of the rig by other means.
rows() { "$BUILD/tests/bench/rig/control" -f 8 -n 0 -s 0 -p rig | awk -F '|' '/^hexid/ { print } /^\| (PID|model)/ { gsub(/[^A-Za-z]+/, "_", $2); print $2, $3 }'; }
claim "make bench-control-rig measures both laws on the rig by other means" table 4 \
    "_PID_as_shipped_ _model_as_configured_ _model_as_identify_model_wrote_it_ _model_the_truth_" rows
