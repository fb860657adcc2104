#!/bin/bash
# The simulated platform beside the wall clock: its time follows and stretches where the host is too slow; the results equal those of
# virtual time to the last bit, whatever the host did meanwhile.
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
