#!/bin/bash
# Gains changed while the daemon runs: where the platform is held, without a fault, and the log says with which gains each part was driven.
# What would make the loop unstable, what is too far away, and what comes in motion is refused; a stop works whatever else.
. tests/scenarios/lib
. tests/scenarios/operators_lib

knows=("${fair[@]}" --set sensors.enabled=false) # what the client must know of the machine
set_gain() { "$hexid" command set "$@" "${knows[@]}"; }
daemon run --log "$work/run.lcm" --set sensors.enabled=false --set tests.duration_s=2 --set tests.settle_s=0.2 --set tests.ramp_s=0.3
"$hexid" command engage >"$work/engage" 2>&1 &
operator=$!
comes '^  ready' run
sleep 1 # the legs have come to rest

claim "without a value it says the gains" eval 'set_gain | grep -qF "set done, now ready: control.kp=40 control.ki=20 control.kd=0 control.kff=2 control.kpf=2e-05"'
claim "a gain changes where the platform is held" eval 'set_gain control.kp=45 | grep -qF "control.kp=45 control.ki=20" && comes "gains: control.kp=45, was 40" run'
sleep 1.2
claim "a second one keeps the first" eval 'set_gain control.kpf=1.5e-5 | grep -qF "control.kp=45 control.ki=20 control.kd=0 control.kff=2 control.kpf=1.5e-05"'
sleep 1.2
claim "more than a factor of 1.4 is refused" refuses 4 "control.kp factor of 1.4" set_gain control.kp=70
claim "a feed-forward that would leave the reference in motion is refused by the client" refuses 4 "control.kff=2.79 limits.following_m" set_gain control.kff=2.79
claim "a gain of 0 stays 0" refuses 4 "control.kd from 0" set_gain control.kd=0.01
claim "a client that has another machine is refused" refuses 4 "configuration is not this machine's" "$hexid" command set control.kp=50
claim "what is no gain is refused" refuses 2 "control.tp control.kp" set_gain control.tp=0.1
claim "so is what is out of its range" refuses 2 "control.kpf" set_gain control.kpf=7
for kpf in $(awk 'BEGIN { for (k = 2e-5; k < 1e-3; k *= 1.38) print k }'); do # up to where the loop would be unstable
    set_gain control.kpf=$kpf >"$work/said" 2>&1 || break
    sleep 1.2
done
claim "gains with which the loop would be unstable are refused by the client" eval 'cat "$work/said"; grep -qE "set refused: with control.kpf=.* .*unstable" "$work/said"'
for step in 1 2 3; do # from the last one that was set
    sleep 1.2
    set_gain control.kpf=$(awk -v k="$kpf" -v n=$step 'BEGIN { print k / 1.38 / 1.3 ^ n }') >"$work/said" 2>&1
done

"$hexid" command start >"$work/start" 2>&1 &
comes 'test 1/6' run
claim "in motion they are refused" refuses 4 "state testing ready settled" set_gain control.kp=46
claim "and a stop works" eval '"$hexid" command stop && comes "^  ready" run 2'
"$hexid" command park >/dev/null && comes '^  settled' run 2
claim "put down they change again" eval 'sleep 1.2; set_gain control.ki=25 | grep -q "control.ki=25"'
wait $operator
ended_by TERM 0 >"$work/end" 2>&1
cat "$work/end" >&2

parts() {
    ends 3 "$hexid" identify "$work/run.lcm" >"$work/list" 2>&1
    cat "$work/list"
    grep -q -- '--run' "$work/list"
}
claim "the log holds a run for each set of gains, and its readers ask which" parts
claim "each with the gains that it had" eval 'grep -qaE "^ *kp: 40 " "$work/run.lcm" && [ "$(grep -caE "^ *kp: 45 " "$work/run.lcm")" -ge 2 ]'

# A feed-forward that is far off cannot be mended in one step.
daemon off --set sensors.enabled=false --set control.kff=5
comes '^  settled' off
claim "a step out of gains that are refused themselves is set, with a warning" eval \
    'set_gain control.kff=3.6 >"$work/said" 2>&1 && grep -q "warning: with control.kff=3.6" "$work/said" && grep -q "set done.*control.kff=3.6" "$work/said"'
sleep 1.2
claim "a step further into them is refused" refuses 4 "control.kff=4 limits.following_m" set_gain control.kff=4
ended_by TERM 0 >"$work/end" 2>&1
