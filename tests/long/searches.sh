#!/bin/bash
# Searches of hexid gap that take half a minute, or that resemble one in make test. Friction and a tilt on six axes are named as two
# effects, although separate friction of each leg would explain the data with more parameters.
for claim in friction_and_a_tilt_are_two_effects hidden_coulomb_friction_is_named_and_the_gap_closes; do
    MORE_CASES=1 "${BUILD:-build}/tests/test_gap" $claim || exit
done
