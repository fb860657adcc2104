#!/bin/bash
# One axis recorded by another program: its own units, semicolons, decimal commas, lost rows, empty cells. Import, gap, extended model.
. tests/scenarios/lib

recorded() { mkdir -p "$work/$1" && "$python" tests/scenarios/axis.py "${@:2}" >"$work/$1/1.csv"; }
import() { "$hexid" import "$work/$1" -c config/axis.yaml -o "$work/$1.lcm"; }
gap() { "$hexid" gap --measured "$work/$1.lcm" -c "${2:-config/axis.yaml}" -o "$work/$1.gap" 2>/dev/null; }
says() { "$python" tests/scenarios/gap.py "$@"; }

imported() {
    recorded friction 80 1 && import friction | tee "$work/said" && grep -q 'missing columns.* ref_m, p1_pa, p2_pa, u$' "$work/said" &&
        grep -q 'motor temperature' "$work/said"
}
claim "a recording of another program is read, what is missing is named" imported
named() {
    gap friction | tee "$work/said" && says "$work/friction.gap/gap.json" cylinder_coulomb_friction && ! grep -q '^  p1' "$work/said"
}
claim "dry friction is named from position and force; pressures are not evaluated" named
# The file states 2 Hz; configuration or command line 4.
own_frequency() {
    sed 's/frequency_hz: 2$/frequency_hz: 4/' config/axis.yaml >"$work/four.yaml" && grep -q 'frequency_hz: 4$' "$work/four.yaml" &&
        gap friction "$work/four.yaml" | tee "$work/said" && ! grep -q 'was stated' "$work/said" || return 1
    "$hexid" gap "$work/friction.lcm" -c config/axis.yaml --set tests.frequency_hz=4 -o "$work/four" 2>&1 | tee "$work/said"
    grep -q "friction.lcm: --set is taken, not what a file states: x: frequency_hz 2$" "$work/said" &&
        "$python" -c 'import json, sys; sys.exit("where 4 was stated" not in json.load(open(sys.argv[1]))["reason"])' "$work/four/gap.json"
}
claim "gap takes the file's own frequency before the configuration's, and that of --set before both" own_frequency
claim "its page has a cylinder's words, and is no wider than a telephone" \
    "$python" tests/scenarios/narrow.py "$work/friction.gap/report.html" "$work" leg legs platform nan
accepted() {
    "$hexid" run -c "$work/friction.gap/model.yaml" --print-config >"$work/printed" &&
        grep -Eq 'force_extend_n: (7[2-9]|8[0-8])' "$work/printed"
}
claim "the extended model is a configuration, within 10 % of the rig's 80 N" accepted
closed() {
    recorded again 80 2 && import again && gap again "$work/friction.gap/model.yaml" &&
        says "$work/again.gap/gap.json" no_gap
}
claim "with it a second recording has no gap" closed
# With less and less memory it either ends with a message or gives the same result.
short_of_memory() {
    for ((kb = 80000; kb > 24000; kb = kb * 9 / 10)); do
        (
            ulimit -v $kb
            "$hexid" gap --measured "$work/friction.lcm" -c config/axis.yaml -o "$work/short" 2>&1 | tail -n 1
        ) 2>&1
        [ ! -e "$work/short/gap.json" ] || says "$work/short/gap.json" cylinder_coulomb_friction || return 1
        rm -rf "$work/short"
    done
    grep -q 'hexid: out of memory' "$work/claim.out"
}
text="no lack of memory becomes a verdict"
if built_with 'asan|tsan'; then echo "ok - $text # SKIP sanitizers need terabytes of addresses"; else claim "$text" short_of_memory; fi
nothing() { recorded nothing 0 3 && import nothing && gap nothing && says "$work/nothing.gap/gap.json" no_gap; }
claim "nothing but the tolerance: no gap" nothing
# The rig has 2000 N s/m and 80 N; the file states 3000.
overstated() {
    sed 's/viscous_n_s_per_m: 2000 /viscous_n_s_per_m: 3000 /' config/axis.yaml >"$work/overstated.yaml" &&
        grep -q 'viscous_n_s_per_m: 3000' "$work/overstated.yaml" && gap friction "$work/overstated.yaml" &&
        says "$work/friction.gap/gap.json" cylinder_viscous_friction,cylinder_coulomb_friction &&
        "$hexid" run -c "$work/friction.gap/model.yaml" --print-config >"$work/printed" &&
        grep -Eq 'extend_n_s_per_m: -(9|10)[0-9]{2}(\.| |$)' "$work/printed" && grep -Eq 'force_extend_n: (7[2-9]|8[0-8])' "$work/printed"
}
claim "friction that the file states and the axis has not is taken off, beside what it lacks" overstated

# Stribeck friction that the axis does not have comes out as zero, with an undetermined speed.
left() {
    "$hexid" gap --measured "$work/nothing.lcm" -c config/axis.yaml --set effects.cylinder_stribeck_friction.excess_n=100 \
        --set effects.cylinder_stribeck_friction.velocity_mps=0.05 -o "$work/left" 2>/dev/null &&
        says "$work/left/gap.json" cylinder_stribeck_friction && grep -q 'excess_n: 0 ' "$work/left/model.yaml" &&
        "$hexid" gap --measured "$work/nothing.lcm" -c "$work/left/model.yaml" -o "$work/again" 2>/dev/null && says "$work/again/gap.json" no_gap
}
claim "an effect that came out as nothing leaves a model that can be read" left

claim "no closed loop for an axis" refuses 2 "mechanism: axis --replay motion" \
    "$hexid" gap --measured "$work/friction.lcm" -c config/axis.yaml --replay closed-loop -o "$work/none"
claim "an axis is not driven" refuses 2 "mechanism: axis" "$hexid" run --fast -c config/axis.yaml
claim "nor has it an inertia matrix" refuses 2 "mechanism: axis" "$hexid" identify "$work/friction.lcm"
# Pressures become forces by the cylinder's areas, which config/axis.yaml does not state.
pressures() {
    recorded cylinder 80 1 cylinder && import cylinder 2>&1 | tee "$work/said" &&
        grep -q 'warning: pressures, and the configuration does not state .*give it actuator.piston_diameter_m and actuator.rod_diameter_m' "$work/said" &&
        refuses 2 "cylinder.lcm: does not state actuator.piston_diameter_m actuator.rod_diameter_m" \
            "$hexid" gap --measured "$work/cylinder.lcm" -c config/axis.yaml -o "$work/none" &&
        ends 1 "$hexid" check "$work/cylinder.lcm" >"$work/said" && tr -s '\n ' ' ' <"$work/said" | grep -q 'gap would refuse it: .* does not state'
}
claim "pressures without the cylinder's diameters are warned of, then refused" pressures
of_a_platform() {
    "$hexid" import "$work/cylinder" -o "$work/platform.lcm" 2>&1 | grep 'does not state' &&
        "$hexid" check "$work/cylinder" | tr -s '\n ' ' ' | grep 'gap would refuse it: .* does not state'
}
claim "a platform's configuration states none of an axis" of_a_platform
one_diameter() {
    "$hexid" gap --measured "$work/cylinder.lcm" -c config/axis.yaml --set actuator.piston_diameter_m=0.05 -o "$work/none" 2>&1 |
        tee "$work/said" | grep -q 'give it actuator.rod_diameter_m' && ! grep -q 'piston' "$work/said"
}
claim "of one diameter the other is asked for" one_diameter
diameters() {
    sed 's/# piston_diameter_m: 0.063 /piston_diameter_m: 0.05 /; s/# rod_diameter_m: 0.045/rod_diameter_m: 0.028/' config/axis.yaml >"$work/own.yaml" &&
        "$hexid" import "$work/cylinder" -c "$work/own.yaml" -o "$work/cylinder.lcm" | tee "$work/said" &&
        grep -q 'areas: 19.63 cm^2 .* 13.48 cm^2 .*piston 50 mm, rod 28 mm' "$work/said" &&
        grep -q 'as in the default configuration: hydraulics.supply_pa 10e6, .*leakage_m3_per_s_pa 3e-11; .* with -c' "$work/said" &&
        gap cylinder "$work/own.yaml" | tr -s '\n ' ' ' | tee "$work/said" && # at one load the two effects look the same
        grep -q 'cannot tell load_dependent_friction from cylinder_coulomb_friction .* load_dependent_friction explains 100.0 %' "$work/said" &&
        "$hexid" run -c "$work/cylinder.gap/model.yaml" --print-config | grep -q 'piston_diameter_m: 0.05 '
}
claim "stated, they are said, and what the cylinder hides is found" diameters
beside() {
    recorded both 80 1 both && "$hexid" import "$work/both" -c "$work/own.yaml" -o "$work/both.lcm" 2>&1 | tee "$work/said" &&
        ! grep -q warning "$work/said" &&
        "$hexid" import "$work/both" -c config/axis.yaml --set actuator.piston_diameter_m=0.063 --set actuator.rod_diameter_m=0.045 -o "$work/both.lcm" 2>&1 |
        grep 'force_n differs from A1 P1 - A2 P2 by 0\.[2-9].* other diameters'
}
claim "another force than that of the pressures is noticed" beside
other_units() {
    recorded lie 80 1 millimetres && import lie 2>&1 | tee "$work/said" && grep -q 'position_m swings by .*, in mm?' "$work/said" &&
        refuses 2 "other units" "$hexid" gap --measured "$work/lie.lcm" -c config/axis.yaml -o "$work/none"
}
claim "millimetres under a name that says metres are named, then refused" other_units
other_frequency() {
    "$hexid" gap --measured "$work/friction.lcm" -c config/axis.yaml --set tests.frequency_hz=3 --set lcm.url= -o "$work/other" 2>&1 |
        tr -s '\n ' ' ' | grep -q 'lacks cylinder_coulomb_friction; the legs move at 2 Hz, where 3 was stated'
}
claim "another frequency than stated is found and said" other_frequency
claim "a platform's model is refused for it" refuses 2 "friction.lcm: is of one axis, the configuration of -c of six legs" \
    "$hexid" gap --measured "$work/friction.lcm" -c config/tian2015.yaml -o "$work/none"
claim "nothing was written for what was refused" eval '[ ! -e "$work/none" ]'
