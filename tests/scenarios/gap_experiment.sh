#!/bin/bash
# What people do after hexid gap has spoken: the experiment it asks for, and the matrix without the friction it found.
. tests/scenarios/lib
if ldd "$hexid" | grep -q 'lib[at]san'; then
    echo "ok - experiments # SKIP minutes under sanitizers; tests/test_gap.c runs the same code"
    exit
fi
rig() { "$hexid" run --hal sim: --fast --set lcm.url= --set sim.engine=ode --log "$work/$1.lcm" "${@:2}" >/dev/null; }
gap() { "$hexid" gap --measured "$work/$1.lcm" -c config/tian2015.yaml -o "$work/$1" --set lcm.url= "${@:2}" >"$work/said" 2>/dev/null; }
field() { "$python" -c 'import json, sys; print(eval("j" + sys.argv[2], {"j": json.load(open(sys.argv[1]))}))' "$work/$1/gap.json" "$2"; }

# separated NAME RIVAL HIDDEN: ambiguous on the six tests; named by the log of the experiment that the verdict asks for.
separated() {
    rig first --seed 4 --set "$3" && gap first || return 1
    cat "$work/said"
    [ "$(field first "['verdict']")" = ambiguous ] || return 1
    field first "['ambiguous_with'] + [e['name'] for e in j['effects']]" | grep -q "$1" || return 1
    read -ra options < <(field first "['next_experiment']" | cut -d'`' -f2)
    rig second --seed 5 --set "$3" "${options[@]}" || return 1
    while [ "${options[0]}" = --tests ]; do options=("${options[@]:2}"); done
    gap second "${options[@]}" --replay motion
    cat "$work/said"
    [ "$(field second "['verdict']") $(field second "['effects'][0]['name']")" = "effect_named $1" ]
}
claim "valve lag or delay? the experiment named tells" separated valve_lag command_delay effects.valve_lag.frequency_hz=70
claim "a spring or an inertia? the experiment named tells" separated external_stiffness payload_rotational_inertia effects.external_stiffness.phi=8000

# repaired MOST SETTING...: the identified matrix without the friction found, all ten entries within so many percent of the nominal one.
repaired() {
    rig friction --set sim.engine=closed_form --set effects.cylinder_coulomb_friction.force_extend_n=100 \
        --set effects.cylinder_coulomb_friction.force_retract_n=100 "${@:2}" && gap friction --replay motion "${@:2}" || return 1
    "$hexid" identify "$work/friction.lcm" --json "$work/friction/ident.json" >/dev/null
    "$python" tests/scenarios/gap.py repaired "$work/friction/gap.json" "$work/friction/ident.json" "$1"
}
claim "100 N of dry friction named and taken off: the matrix is within 2 % of the nominal one" repaired 2 --set sensors.enabled=false
claim "and with noisy sensors within what they scatter without friction" repaired 4
