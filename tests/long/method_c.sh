#!/bin/bash
# Compares the deviations that method C states with errors over many draws; make test has one case of each kind.
for claim in logs_that_differ_by_noise_agree sensors_within_their_tolerances_are_in_the_stated_deviation \
    noise_of_small_motion_is_no_error_of_the_drawing; do
    MORE_CASES=1 "${BUILD:-build}/tests/test_method_c" $claim || exit
done
