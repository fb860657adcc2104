#!/bin/bash
# hexid on the recordings of an independent rig (tests/rig/): its own checks, identification, and hidden effects beside a base in which each
# leg has its own deviation; rig_laws.sh has more of them.
. tests/long/score_lib
skip_under 'asan|tsan' "the rig by other means" "minutes under sanitizers; tests/test_gap.c runs the same code"
export RIG=${BUILD:-build}/tests/rig/rig

claim "its energy, statics, friction and step size hold, and hexid identifies its matrix" tests/rig/check.sh
claim "each leg its own tolerance and nothing else: no gap" right none typical 1 tolerance
claim "friction is named beside it" right cylinder_coulomb_friction typical 1 tolerance
claim "so is another mass centre" right payload_center_of_mass typical 1 tolerance
claim "and heavier actuators, which weigh more, are no payload" right actuator_inertia typical 1 tolerance
SET="${exact[*]}" claim "one leg's other masses are named beside another leg's valve null, where gauges are exact" \
    right actuator_inertia+valve_null_bias typical 1511 tolerance
claim "another mass with another inertia is not taken for springs alone" \
    right payload_mass+payload_rotational_inertia typical 5501 tolerance
claim "springs are named, though joints and supply are off" right external_stiffness typical 1201 beyond
