#!/bin/bash
# Steps after hexid gap has reported: the experiment it asks for, and the matrix without the friction it found.
. tests/scenarios/lib
skip_under 'asan|tsan' "experiments" "minutes under sanitizers; tests/test_gap.c runs the same code"
machine=(--set payload.mass_kg=179.7 --set payload.inertia_xx_kg_m2=13.5 --set payload.inertia_yy_kg_m2=13.7
    --set hydraulics.bulk_modulus_pa=1.03e9 --set hydraulics.valve_flow_m3_per_s=1.53e-3 --set hydraulics.viscous_n_s_per_m=2060
    --set hydraulics.leakage_m3_per_s_pa=2.9e-11)
rig() { "$hexid" run --hal sim: --fast --set lcm.url= --set sim.engine=ode --set sim.substeps=16 --log "$work/$1.lcm" "${@:2}" >/dev/null; }
gap() { "$hexid" gap -c config/tian2015.yaml -o "$work/out" --set lcm.url= "$@" >"$work/said" 2>/dev/null || return; cat "$work/said"; }
field() { "$python" -c 'import json, sys; print(eval("j" + sys.argv[2], {"j": json.load(open(sys.argv[1]))}))' "$work/out/gap.json" "$1"; }

# separated HIDDEN VALUE RIVAL [OPTION...]: the effect is ambiguous on the six tests; with the log of the experiment that the verdict proposes, it is
# named alone.
separated() {
    local name=${1%.*} rival=$3 options given=("${@:4}")
    rig first --seed 4 "${machine[@]}" --set "effects.$1=$2"
    gap --measured "$work/first.lcm" "${given[@]}" || return
    [ "$(field "['verdict']")" = ambiguous ] || return
    options="$(field "['in_doubt']") $(field "['ambiguous_with']")"
    [[ $options == *"$name"* && $options == *"$rival"* ]] || return
    read -ra options < <(field "['next_experiment']" | cut -d'`' -f2)
    rig second --seed 5 "${machine[@]}" --set "effects.$1=$2" "${options[@]}" # fewer than six tests: no matrix, exit status 1
    gap --measured "$work/first.lcm" --measured "$work/second.lcm" "${given[@]}" || return
    [ "$(field "['verdict']") $(field "['effects'][0]['name']") $(field "['effects'].__len__()")" = "effect_named $name 1" ]
}
claim "a spring or an inertia? the experiment that the verdict asks for tells" \
    separated external_stiffness.phi 8000 payload_rotational_inertia
claim "a spool's lag or a delay of the command? 36 Hz beside 4 Hz tell, where gauges are exact" \
    separated valve_lag.frequency_hz 80 command_delay "${exact[@]/#/--set=}"

# repaired PERCENT DEVIATIONS SETTING...: the identified matrix without the found friction is within PERCENT of the nominal one and within
# DEVIATIONS standard deviations of the sensors' noise.
repaired() {
    # With friction in it, the matrix may differ from its transpose by more than a verdict allows: exit status 1.
    rig friction --set effects.cylinder_coulomb_friction.force_extend_n=100 \
        --set effects.cylinder_coulomb_friction.force_retract_n=100 "${@:3}"
    gap --measured "$work/friction.lcm" --replay motion "${@:3}" || return
    "$hexid" identify "$work/friction.lcm" --json "$work/out/ident.json" >/dev/null
    "$python" tests/scenarios/gap.py repaired "$work/out/gap.json" "$work/out/ident.json" "$1" "$2"
}
claim "100 N of dry friction named and taken off: the matrix is within 2 % of the nominal one" repaired 2 0 --set sensors.enabled=false
# 2.5 % in the coupling are one deviation; with the friction included the coupling is 50 % off.
claim "with noisy sensors within three standard deviations of the noise" repaired 0 3
