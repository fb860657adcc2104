#!/bin/bash
# Checks `make bench-control`, at one frequency.
. tests/bench/check_lib
# Makes one word of each row's name, and keeps the cells.
rows() { "$BUILD/tests/bench/control" 4 | awk -F '|' '/^hexid/ { print } /^\| (PID|model)/ { gsub(/[^A-Za-z]+/, "_", $2); print $2, $3 }'; }
claim "make bench-control measures both laws, with each payload" table 4 \
    "_PID_as_shipped_ _PID_as_tuned_ _model_payload_too_light_ _model_method_A_s_matrix_ _model_as_identify_model_wrote_it_ _model_the_truth_" rows
