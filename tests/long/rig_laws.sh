#!/bin/bash
# Hidden effects of the independent rig, as in rig.sh: laws that are nearly the catalogue's, joints, and another motion.
. tests/long/score_lib
skip_under 'asan|tsan' "the rig by other means" "minutes under sanitizers; tests/test_gap.c runs the same code"
export RIG=${BUILD:-build}/tests/rig/rig

claim "friction that varies by a tenth along the stroke is friction" right nearly_uneven_friction typical 9001 tolerance
claim "leakage that is turbulent is leakage" right nearly_turbulent_leakage typical 9001 tolerance
# changing: true if the friction is found, and said to be larger in an earlier test than in a later one.
changing() {
    local kept=$work/changing
    mkdir -p "$kept" && KEEP=$kept "$python" tests/gap/score.py case "$@" && "$python" -c '
import json, sys
gap = json.load(open(sys.argv[1]))
course = gap["course"]
print(gap["verdict"], gap["reason"], course)
sys.exit(not (gap["verdict"] == "effect_named" and "times as large in test" in gap["reason"] and course["effect"] == "cylinder_coulomb_friction"
              and course["most"]["number"] < course["least"]["number"] and 1.3 < course["ratio"] < 1.8))' "$kept/out/gap.json"
}
claim "friction that falls by half while the seals warm up is said to change" changing unknown_warming_friction typical 9001 tolerance
# valued: true if the effect is also named with its value, within 5 % or two stated deviations.
valued() { right "$@" && [ "$(cut -d, -f12 "$work/row")" = 1 ]; }
claim "friction in the joints of one leg has its leg and value, the joints' axes being stated" \
    valued passive_joint_friction strong 1501 tolerance
claim "backlash in all legs is named with its value, rods knocking" valued joint_backlash typical 1501 tolerance
# listed: true if these two effects are the findings, one of which may be ambiguous with an effect of six values or more: backlash's law leaves
# so many squares that such an effect takes up about as many of them as a tilt.
listed() {
    "$python" tests/gap/score.py case "$@" >"$work/row"
    cat "$work/row"
    [ "$(cut -d, -f7 "$work/row" | tr ' ' '\n' | sort | paste -sd+)" = "$1" ] && [[ $(cut -d, -f8 "$work/row") =~ ^(actuator_inertia|external_stiffness)?$ ]]
}
SET="${exact[*]}" claim "so is a tilted base beside it, where gauges are exact, or as masses of each actuator or springs" \
    listed base_tilt+joint_backlash typical 1524 tolerance
# alone: true if no other effect is named beside it.
alone() { right "$@" && [ "$(cut -d, -f7 "$work/row")" = "$1" ]; }
MOTION=multisine claim "dry friction under a multisine is no play of the joints" alone cylinder_coulomb_friction typical 1601 tolerance
