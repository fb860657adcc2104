#!/bin/bash
# Machines of other sizes, joints given as points, unequal legs, an off-centre payload: the independent rig (tests/rig/) reads the same
# files, simulates them with sensors and dry friction, and prints its own bodies' inertia matrix.
. tests/scenarios/lib
skip_under 'asan|tsan' "the rig on other machines" "minutes under sanitizers; tests/test_ident.c runs the same code"
rig=${BUILD:-build}/tests/rig/rig

# recorded FILE FRICTION_N: writes the rig's matrix and hexid's result for its recording. Method A's checks need not pass with dry friction.
recorded() {
    "$rig" -c "$1" --inertia-matrix >"$work/matrix" &&
        "$rig" -c "$1" -o "$work/measured" --effect "cylinder_coulomb_friction.force_extend_n=$2" \
            --effect "cylinder_coulomb_friction.force_retract_n=$2" &&
        "$hexid" import "$work/measured" -c "$1" -o "$work/run.lcm" || return 1
    "$hexid" identify "$work/run.lcm" --json "$work/run.json"
    (($? <= 1))
}
is() { "$python" tests/long/rig_machines.py "$1" "$work/run.json" "${@:2}"; }

machine() {
    local name=$1 config=$2 friction_n=$3
    claim "$name: recorded by the rig and identified" recorded "$config" "$friction_n"
    claim "$name: hexid's nominal matrix is that of the rig's bodies to 1e-6" is nominal "$work/matrix" 1e-6
    claim "$name: method C's 21 entries are the rig's within 3 stated deviations" is covered "$work/matrix" 3
    claim "$name: and within 2 % of the root of the diagonal's product" is close "$work/matrix" 2
    claim "$name: $friction_n N of dry friction found: each leg within 3 stated deviations, their mean within 5 %" \
        is friction "$friction_n" 5 3
}
machine "desk-top platform" config/desktop.yaml 8
machine "flight simulator's size" config/simulator.yaml 1500
