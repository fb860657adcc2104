#!/bin/bash
# A known weight and legs on their stops reveal errors of the sensors: sensors with errors are simulated, their errors found, and the matrix
# identified with and without that.
. tests/scenarios/lib

run() { # NAME SEED [OPTION ...]
    "$hexid" run --fast --seed "$2" --set sim.engine=closed_form --set lcm.url= --set tests.settle_s=0.5 --log "$work/$1.lcm" "${@:3}" >"$work/said" 2>&1 || [ $? = 1 ]
}
identify() { # RESULT OPTION ...
    "$hexid" identify "${@:2}" --json "$work/$1.json" >"$work/said" 2>&1 || [ $? = 1 ]
}
judge() { python3 tests/scenarios/calibration.py "$@"; }
gains() { echo "--set effects.pressure_sensor_scale.p1=$1 --set effects.pressure_sensor_scale.p2=$1"; }

rest=(--set motion.rest_s=20)
if [ -n "${MORE_CASES:-}" ]; then # make test-long
    run without 5 $(gains 1.02) "${rest[@]}" && run with 6 $(gains 1.02) "${rest[@]}" --set effects.payload_mass.mass_kg=100
    claim "a gain that is 2 % off in all pressures fails the verdict, by the weight" \
        eval 'identify found "$work/without.lcm" "$work/with.lcm" --weight 100 && judge fails "$work/found.json" "the known weight reads"'
    exit
fi

desktop="-c config/desktop.yaml"
zeros="effects.position_sensor_offset.offset_m=[1.1e-3,-0.7e-3,0.4e-3,-1.5e-3,0.9e-3,0.2e-3]"
run stops 1 $desktop && run zeros 2 $desktop --set "$zeros" && identify stops "$work/stops.lcm" && identify alone "$work/zeros.lcm"
stated=$(judge lengths "$work/stops.json")
claim "legs on their stops: the zeros of the lengths are found, and masses are known better" \
    eval 'identify found "$work/zeros.lcm" --set "actuator.retracted_m=$stated" --set actuator.retracted_std_m=2e-4 &&
          judge zeros "$work/alone.json" "$work/found.json" "$zeros"'

drift="effects.pressure_sensor_offset.p1=[900,-1300,2100,-400,1500,-1700]"
run without 3 $(gains 1.004) "${rest[@]}" && run with 4 $(gains 1.004) "${rest[@]}" --set "$drift" --set effects.payload_mass.mass_kg=100 && identify alone "$work/without.lcm"
claim "a weight of 100 kg, and zeros that drift between the logs: the gain that all pressures have in common is found, and masses are known better" \
    eval 'identify found "$work/without.lcm" "$work/with.lcm" --weight 100,0.01 -o "$work/machine.yaml" &&
          judge weight "$work/alone.json" "$work/found.json" 0.004'
claim "what it found is in the configuration of -o: the same log with it has the same matrix" \
    eval 'identify again "$work/without.lcm" -c "$work/machine.yaml" && judge same "$work/found.json" "$work/again.json"'

# says_gain OPTION ...: prints how often the table names the common gain, and its deviation in the JSON in millionths; 0: it is not there.
says_gain() {
    "$hexid" identify "$@" --json "$work/gain.json" 2>/dev/null | tee "$work/gain.out" | grep -c 'gain      that all pressures have in common: no motion shows it'
    "$python" -c 'import json, sys
gain = json.load(open(sys.argv[1]))["method_c"].get("common_gain")
print(0 if gain is None else round(1e6 * gain["prior_std"]))' "$work/gain.json"
}
in_page() { "$hexid" report "$work/without.lcm" "$@" -o "$work/gain.html" >/dev/null; grep -c 'A gain that all pressures have in common shows in no motion' "$work/gain.html"; }
claim "without a weight table, page and JSON say what the gain common to all pressures rests on, 0.5 % / sqrt(12); with it they do not" \
    eval '[ "$(says_gain "$work/without.lcm" | xargs)" = "1 1443" ] && grep "+- 0.28 % by model.tolerance.pressure_gain" "$work/gain.out" &&
          [ "$(says_gain "$work/without.lcm" "$work/with.lcm" --weight 100,0.01 | xargs)" = "0 0" ] &&
          [ "$(says_gain "$work/without.lcm" -c "$work/machine.yaml" | xargs)" = "0 0" ] &&
          [ "$(in_page)" = 1 ] && [ "$(in_page -c "$work/machine.yaml")" = 0 ]'

refused() { "$hexid" identify "$@" >"$work/said" 2>&1; [ $? = 2 ] && cat "$work/said"; }
claim "logs in the wrong order are refused" eval 'refused "$work/with.lcm" "$work/without.lcm" --weight 100 | grep -q "without the weight"'
claim "one log is refused" eval 'refused "$work/without.lcm" --weight 100 | grep -q "name two logs"'
claim "a mass that is no number is refused" eval 'refused "$work/without.lcm" "$work/with.lcm" --weight 100kg | grep -q "the mass in kg"'
