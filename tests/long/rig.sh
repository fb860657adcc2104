#!/bin/bash
# hexid on the recordings of an independent rig (tests/rig/): its own checks, identification, and hidden effects beside a base in which each
# leg has its own deviation.
. tests/scenarios/lib
skip_under 'asan|tsan' "the rig by other means" "minutes under sanitizers; tests/test_gap.c runs the same code"
export HEXID=$hexid RIG=${BUILD:-build}/tests/rig/rig

claim "its energy, statics, friction and step size hold, and hexid identifies its matrix" tests/rig/check.sh
# right CASE SIZE SEED SERIES: true if the hidden effect is found (tests/gap/score.py).
right() {
    "$python" tests/gap/score.py case "$@" >"$work/row"
    cat "$work/row"
    [ "$(cut -d, -f9 "$work/row")" = 1 ]
}
claim "each leg its own tolerance and nothing else: no gap" right none typical 1 tolerance
claim "friction is named beside it" right cylinder_coulomb_friction typical 1 tolerance
claim "so is another mass centre" right payload_center_of_mass typical 1 tolerance
claim "and heavier actuators, which weigh more, are no payload" right actuator_inertia typical 1 tolerance
SET="${exact[*]}" claim "one leg's other masses are named beside another leg's valve null, where gauges are exact" \
    right actuator_inertia+valve_null_bias typical 1511 tolerance
claim "another mass with another inertia is not taken for springs alone" right payload_mass+payload_rotational_inertia typical 5501 tolerance
claim "friction that varies by a tenth along the stroke is friction" right nearly_uneven_friction typical 9001 tolerance
claim "leakage that is turbulent is leakage" right nearly_turbulent_leakage typical 9001 tolerance
# valued: true if the effect is also named with its value, within 5 % or two stated deviations.
valued() { right "$@" && [ "$(cut -d, -f12 "$work/row")" = 1 ]; }
claim "friction in the joints of one leg has its leg and value, the joints' axes being stated" \
    valued passive_joint_friction strong 1501 tolerance
claim "backlash in all legs is named with its value, rods knocking" valued joint_backlash typical 1501 tolerance
SET="${exact[*]}" claim "so is a tilted base beside it, where gauges are exact" right base_tilt+joint_backlash typical 1524 tolerance
# alone: true if no other effect is named beside it.
alone() { right "$@" && [ "$(cut -d, -f7 "$work/row")" = "$1" ]; }
MOTION=multisine claim "dry friction under a multisine is no play of the joints" alone cylinder_coulomb_friction typical 1601 tolerance
claim "springs are named, though joints and supply are off" right external_stiffness typical 1201 beyond
