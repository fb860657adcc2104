#!/bin/bash
# Two effects are hidden.
. tests/long/score_lib

claim "two effects at once are both named" right valve_null_bias+cylinder_coulomb_friction typical 1 tolerance
claim "so is one leg's friction beside five times the leakage" right cylinder_stribeck_friction+internal_leakage typical 703 tolerance
# A mass centre 10 mm off is 17 N in some legs, where a usual gauge's zero may be 250 N off and a lag turns the phase.
SET="${exact[*]}" claim "a lag beside another mass centre is no delay, where gauges are exact" \
    right valve_lag+payload_center_of_mass typical 206 tolerance
