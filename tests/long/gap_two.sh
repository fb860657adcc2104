#!/bin/bash
# Friction and a tilt on six axes: two effects, where friction of each leg its own would do with more numbers.
MORE_CASES=1 exec "${BUILD:-build}/tests/test_gap" friction_and_a_tilt_are_two_effects
