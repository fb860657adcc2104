#!/bin/bash
# Whole runs under the control law `model`: the tests follow closely, the identification is as good as under the PID, faults are found as
# they are under the PID, and a pressure that is lost hands over to it.
. tests/scenarios/lib
. tests/scenarios/fault_lib

law=(--fast --set lcm.url= --set sim.engine=closed_form --set tests.settle_s=1)
quick --json "$work/clean.json" >"$work/out" || { cat "$work/out"; exit 1; }
whole() { "$hexid" run "${law[@]}" --set "control.law=$1" --json "$work/$1.json" --log "$work/$1.lcm" "${@:2}" >"$work/$1.out" || { cat "$work/$1.out"; return 1; }; }
claim "a whole run under the law passes its tests" whole model
whole pid
claim "4 Hz: amplitudes within 0.5 %, phases within 0.2 degrees" "$python" - "$work/model.json" <<'END'
import json, sys
tests = json.load(open(sys.argv[1]))["tests"]
worst = max(abs(t["achieved_amplitude"] / t["amplitude"] - 1.0) for t in tests), max(abs(t["phase_deg"]) for t in tests)
print(len(tests), worst)
sys.exit(not (len(tests) == 6 and worst[0] < 0.005 and worst[1] < 0.2))
END
claim "it identifies as well as under the PID: method C's errors within its intervals, which are as wide within a quarter" \
    "$python" - "$work/model.json" "$work/pid.json" <<'END'
import json, sys
model, pid = (json.load(open(name)) for name in sys.argv[1:])
def figures(run):
    c, nominal = run["method_c"], run["nominal"]["Mt"]
    return [(abs(c["Mt"][i][i] - nominal[i][i]) / nominal[i][i], 1.96 * c["std"][i][i] / nominal[i][i]) for i in range(6)]
pairs = list(zip(figures(model), figures(pid)))
print(pairs)
sys.exit(not all(m[0] < m[1] and m[1] < 1.25 * p[1] for m, p in pairs))
END
"$hexid" run "${law[@]}" --set control.law=model --hal "fault:pressure_nan@15+0.006/3;sim:" >"$work/said" 2>&1
claim "a pressure that is lost for 6 ms hands over to the PID, and that is said" \
    grep -F "pid drives in place of the law model: a pressure is no valid reading" "$work/said"
claim "and the law comes back" grep -F "the law model drives again" "$work/said"
claim "control.delay_s beyond the law's horizon is refused by name" \
    refuses 2 "control.delay_s control.law" "$hexid" run "${law[@]}" --set control.law=model --set control.delay_s=0.09 \
    --set control.kp=1 --set control.ki=0 --set control.kpf=0 # gains that are stable with such a delay

# The run is the one of faults.sh, except for the law.
quick+=(--set control.law=model)
some() {
    campaign <<'END'
frame loss 1 %|loss@0.5+100=1|0.5|flagged|1000
length jumps 10 mm|length@5.91+100/3=0.01|5.91|leg_rate|5
lengths of legs 2 and 3 swapped|swap@5.91+100/2|5.91|following_error/leg_rate|300
not a number|nan@5.91+100/2|5.91|sensor_invalid|5
pressures of a leg lost|pressure_nan@5.91+100/3|5.91|pressure_sensor|5
all pressures lost|pressure_nan@5.91+100|5.91|pressure_sensor|5
supply lost: its relay opens|supply@5.91+100|5.91|supply|40
valve stuck in motion|stuck@5.91+100/3|5.91|following_error|150
END
}
claim "faults under the law: detected in time, never identified wrongly in silence" some
