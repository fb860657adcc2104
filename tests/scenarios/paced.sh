#!/bin/bash
# The simulated platform beside the wall clock: its time follows and stretches where the host is too slow; the results equal those of
# virtual time to the last bit, whatever the host did meanwhile. A real machine's time does not stretch.
. tests/scenarios/lib
lcm-gen -p --ppath "$work" lcmtypes/*.lcm

settings=(--seed 3 --tests z,psi --set tests.duration_s=0.5)
stalled_run() { # stalled by 0.3 s while it rises
    local line
    mkfifo "$work/lines"
    "$hexid" run --hal sim: --rt off "${quick_settings[@]}" "${settings[@]}" --log "$work/paced.lcm" --json "$work/paced.json" \
        >"$work/lines" &
    run=$!
    while read -r line; do
        echo "$line"
        [[ $line == *engaging* ]] && kill -STOP $run && sleep 0.3 && kill -CONT $run
    done <"$work/lines"
    wait $run
}
quick "${settings[@]}" --log "$work/fast.lcm" --json "$work/fast.json" >/dev/null
stalled_run >"$work/paced"
same() { PYTHONPATH=$work "$python" tests/scenarios/paced.py "$work"/{fast,paced}.lcm "$work"/{fast,paced}.json; }
claim "a run beside the wall clock gives what virtual time gives, to the last bit; its stamps are the wall clock's" same
claim "and says how far it was behind" grep -q 'x real time, [1-9][0-9]* stall.* of this host, the longest [0-9]*[2-9][0-9][0-9] ms' "$work/paced"

# not_stretched: on a machine that stands, beside a loop that is stopped; whatever else a busy host causes, deadlines are missed.
not_stretched() {
    local line url plant run
    "$hexid" plant --bus modbus:tcp://127.0.0.1:0 --rt off --set sim.engine=closed_form >"$work/plant" 2>&1 &
    plant=$!
    until url=$(sed -n 's/.*ready on //p' "$work/plant") && [ "$url" ]; do kill -0 $plant && sleep 0.05 || return; done
    rm -f "$work/lines" && mkfifo "$work/lines"
    "$hexid" run --hal "$url" --rt off "${quick_settings[@]}" --log "$work/real.lcm" >"$work/lines" 2>&1 &
    run=$!
    while read -r line; do
        echo "$line"
        [[ $line == *settled* ]] && kill -STOP $run && sleep 0.3 && kill -CONT $run && sleep 0.1 && kill $run
    done <"$work/lines"
    wait $run
    kill $plant && wait $plant
    PYTHONPATH=$work "$python" -c 'import hexid, lcm, sys
cycles = [hexid.state_t.decode(e.data) for e in lcm.EventLog(sys.argv[1], "r") if e.channel == "HEXID_STATE"]
print(len(cycles), "cycles, faults", cycles[-1].faults)
sys.exit(not cycles[-1].faults & 128)' "$work/real.lcm"
}
claim "a real machine's time does not stretch, with or without real-time priority: deadlines are missed" not_stretched
