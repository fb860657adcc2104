#!/bin/bash
# A fixed draw of hidden cases against hexid gap (tests/gap/score.py draws, hides and judges; make bench-gap is the whole of it). make test
# has what is hidden in tests/test_gap.c, tests/test_axis.c and gap.sh.
. tests/scenarios/lib
export HEXID=$hexid SUBSTEPS=8

# right CASE SIZE SEED SERIES: is what was hidden found?
right() {
    "$python" tests/gap/score.py case "$@" >"$work/row"
    cat "$work/row"
    [ "$(cut -d, -f9 "$work/row")" = 1 ]
}
claim "nothing but the base's tolerance: no gap" right none typical 1 tolerance
claim "a base on springs is no effect of the catalogue, and said to be none" right unknown_base_spring typical 11 tolerance
claim "leakage in some leg is named, though joints and supply are off" right internal_leakage typical 1 beyond
claim "nothing but what no tolerance states: no gap" right none typical 2 beyond
claim "a leg that may be held takes up noise: that is no friction" right none typical 706 tolerance
claim "friction in the joints is named" right passive_joint_friction typical 3 tolerance
claim "a heavier payload is named" right payload_mass typical 2 tolerance
claim "a slow pressure sensor is named" right pressure_sensor_lag typical 1 tolerance
claim "joints that lie elsewhere are named" right geometry_error strong 100 tolerance
claim "joints that lie elsewhere in every leg are no tilt" right geometry_error typical 302 tolerance
claim "valves that stay shut leave chambers without a steady state, and are named" right valve_dead_band strong 300 tolerance
claim "two effects at once are both named" right valve_null_bias+cylinder_coulomb_friction typical 1 tolerance
claim "so is one leg's friction beside five times the leakage" right cylinder_stribeck_friction+internal_leakage typical 703 tolerance
claim "a lag beside another mass centre is no delay" right valve_lag+payload_center_of_mass typical 206 tolerance
