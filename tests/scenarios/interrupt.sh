#!/bin/bash
# Ctrl-C at any moment parks the platform, closes the log, and exits 1 with the verdict not_evaluated.
. tests/scenarios/lib

lcm-gen -p --ppath "$work" lcmtypes/*.lcm

# Runs with a minute for everything, and sends the signals as soon as the run prints a line that matches.
interrupt_at() {
    local pattern=$1 run status
    shift
    rm -f "$work/lines"
    mkfifo "$work/lines"
    quick --set motion.engage_s=60 --set motion.park_s=60 --set motion.hold_s=60 --set tests.settle_s=60 --set tests.duration_s=60 \
        --log "$work/run.lcm" --json "$work/run.json" >"$work/lines" 2>"$work/error" &
    run=$!
    {
        while read -r line; do
            echo "$line"
            [[ $line =~ $pattern ]] && for signal in "$@"; do kill -"$signal" $run; done && pattern='no such line'
        done
    } <"$work/lines"
    wait $run
    status=$?
    cat "$work/error"
    echo "exit status $status"
    [ $status -eq 1 ]
}
not_evaluated() { "$python" -c 'import json, sys; v = json.load(open(sys.argv[1]))["verdict"]; print(v); sys.exit(v["status"] != "not_evaluated")' "$work/run.json"; }
log_is_whole() { "$hexid" identify "$work/run.lcm" 2>"$work/error" >/dev/null; cat "$work/error"; ! grep -q 'cut' "$work/error"; }
ends_settled() { # the last cycle in the log, by LCM's own Python library
    PYTHONPATH=$work "$python" -c 'import hexid, lcm, sys
for event in lcm.EventLog(sys.argv[1], "r"):
    if event.channel == "HEXID_STATE": last = event
state = hexid.state_t.decode(last.data)
print("state", state.state, "enable", state.enable)
sys.exit(state.state != 1 or state.enable)' "$work/run.lcm"
}

parks() { interrupt_at "$@" && not_evaluated && log_is_whole && ends_settled; }

claim "SIGINT before anything moves: parked, log closed, not evaluated" parks settled INT
claim "SIGINT while engaging: parked, log closed, not evaluated" parks engaging INT
claim "SIGINT at neutral: parked, log closed, not evaluated" parks ready INT
claim "SIGINT in a test: parked, log closed, not evaluated" parks 'test 1/6' INT
claim "SIGTERM in a test: the same" parks 'test 1/6' TERM
claim "SIGINT while parking: parked, log closed, not evaluated" parks parking INT
claim "SIGHUP, the terminal is gone: the same" parks 'test 2/6' HUP
