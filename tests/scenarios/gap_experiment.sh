#!/bin/bash
# What people do after hexid gap has spoken: the experiment it asks for, and the matrix without the friction it found.
. tests/scenarios/lib
skip_under 'asan|tsan' "experiments" "minutes under sanitizers; tests/test_gap.c runs the same code"
rig() { "$hexid" run --hal sim: --fast --set lcm.url= --set sim.engine=ode --log "$work/$1.lcm" "${@:2}" >/dev/null; }
gap() { "$hexid" gap -c config/tian2015.yaml --measured "$work/$1.lcm" -o "$work/$1" --set lcm.url= "${@:2}" >"$work/said" 2>/dev/null; }
field() { "$python" -c 'import json, sys; print(eval("j" + sys.argv[2], {"j": json.load(open(sys.argv[1]))}))' "$work/$1/gap.json" "$2"; }

# Ambiguous on the six tests. The experiment that the verdict asks for, judged by the model found: what is not there is refuted by a new gap, and
# what is there, in its place, leaves none.
separated() {
    local hidden=effects.external_stiffness.phi=8000 options
    rig first --seed 4 --set "$hidden" && gap first || return 1
    cat "$work/said"
    [ "$(field first "['verdict']") $(field first "['effects'][0]['name']")" = "ambiguous payload_rotational_inertia" ] || return 1
    field first "['ambiguous_with']" | grep -q external_stiffness || return 1
    read -ra options < <(field first "['next_experiment']" | cut -d'`' -f2)
    rig second --seed 5 --set "$hidden" "${options[@]}" # three tests: no matrix, exit status 1
    options=("${options[@]:2}") # but for --tests
    gap second "${options[@]}" --replay motion -c "$work/first/model.yaml"
    cat "$work/said"
    [ "$(field second "['verdict']")" != no_gap ] || return 1
    gap second "${options[@]}" --replay motion --set "$hidden"
    cat "$work/said"
    [ "$(field second "['verdict']")" = no_gap ]
}
claim "a spring or an inertia? the experiment that the verdict names tells" separated

# repaired DIAGONAL COUPLING SETTING...: the identified matrix without the friction found, within so many percent of the nominal one.
repaired() {
    rig friction --set sim.engine=closed_form --set effects.cylinder_coulomb_friction.force_extend_n=100 \
        --set effects.cylinder_coulomb_friction.force_retract_n=100 "${@:3}" && gap friction --replay motion "${@:3}" || return 1
    "$hexid" identify "$work/friction.lcm" --json "$work/friction/ident.json" >/dev/null
    "$python" tests/scenarios/gap.py repaired "$work/friction/gap.json" "$work/friction/ident.json" "$1" "$2"
}
claim "100 N of dry friction named and taken off: the matrix is within 2 % of the nominal one" repaired 2 2 --set sensors.enabled=false
claim "with noisy sensors within 2 % on the diagonal, and 15 % instead of 50 in the coupling" repaired 2 15
