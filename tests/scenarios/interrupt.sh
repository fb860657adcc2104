#!/bin/bash
# Ctrl-C at any moment parks the platform, closes the log, and exits 1 with the verdict not_evaluated.
. tests/scenarios/lib

lcm-gen -p --ppath "$work" lcmtypes/*.lcm

under=(env --default-signal=HUP) # whoever runs the tests may have started them with nohup
# interrupt_at SIGNAL PATTERN SETTING...: sends the signal as soon as the run prints a line that matches.
interrupt_at() {
    local signal=$1 pattern=$2 run status line settings=()
    shift 2
    for setting in "$@"; do settings+=(--set "$setting"); done
    rm -f "$work/lines"
    mkfifo "$work/lines"
    "${under[@]}" "${quick[@]}" "${settings[@]}" --log "$work/run.lcm" --json "$work/run.json" >"$work/lines" 2>"$work/error" &
    run=$!
    while read -r line; do
        echo "$line"
        [[ $pattern && $line =~ $pattern ]] && kill -"$signal" $run && pattern= # once
    done <"$work/lines"
    wait $run
    status=$?
    cat "$work/error"
    echo "exit status $status"
    return $status
}
not_evaluated() {
    "$python" -c 'import json, sys
v = json.load(open(sys.argv[1]))["verdict"]
print(v)
sys.exit(v["status"] != "not_evaluated")' "$work/run.json"
}
log_is_whole() { "$hexid" identify "$work/run.lcm" 2>"$work/error" >/dev/null; cat "$work/error"; ! grep -q 'cut' "$work/error"; }
put_down() { # true if the platform is down in the log's last cycle, read by LCM's own Python library
    PYTHONPATH=$work "$python" -c 'import hexid, lcm, sys
for event in lcm.EventLog(sys.argv[1], "r"):
    if event.channel == "HEXID_STATE": last = event
state = hexid.state_t.decode(last.data)
print("state", state.state, "enable", state.enable, "z", state.pose_m[2])
sys.exit(state.state != 1 or state.enable)' "$work/run.lcm"
}
parks() { ends 1 interrupt_at "$@" && not_evaluated && log_is_whole && put_down; }

# A second signal comes from a person, while the platform is put down for ten minutes of the run's time; within 0.3 s of the first it would
# count as the same signal.
twice() {
    local run status
    rm -f "$work/lines"
    mkfifo "$work/lines"
    "${quick[@]}" --set motion.hold_s=60 --set motion.park_s=600 --log "$work/run.lcm" >"$work/lines" 2>"$work/error" &
    run=$!
    while read -r line; do
        [[ $line =~ ready ]] && kill -INT $run
        [[ $line =~ parking ]] && sleep 0.4 && kill -INT $run
    done <"$work/lines"
    wait $run
    status=$?
    cat "$work/error"
    echo "exit status $status"
    [ $status -eq 1 ] && grep -q 'interrupted again: valves centred' "$work/error" && ! put_down
}

ends_tests() {
    ends 1 interrupt_at INT 'test 1/6' tests.duration_s=60 >"$work/run.out" || { cat "$work/run.out"; return 1; }
    cat "$work/run.out"
    ! grep -q 'test [3-6]/6' "$work/run.out"
}

goes_on() {
    "${quick[@]}" --log "$work/run.lcm" | head -n 1
    local status=${PIPESTATUS[0]}
    echo "exit status $status"
    [ "$status" -eq 0 ] && log_is_whole && put_down
}

# ---- while the main thread is held up ----

gcc -O1 -shared -fPIC -D_GNU_SOURCE -o "$work/held_up.so" tests/scenarios/held_up.c -ldl
held=(--set motion.hold_s=60 --set tests.duration_s=60 --set security.confine=false) # confined it may not look for the file
# held_up AGAIN: while the main thread hangs, SIGINT comes at neutral and, with AGAIN, once more while the platform is put down. The main
# thread comes round when the platform is down, or right after the second signal.
held_up() {
    local again=$1 run status line
    rm -f "$work/lines"
    mkfifo "$work/lines"
    touch "$work/held"
    LD_PRELOAD=$work/held_up.so HELD_UP=$work/held "${quick[@]}" "${held[@]}" --set motion.park_s="$([ "$again" ] && echo 600 || echo 2)" \
        --log "$work/run.lcm" --json "$work/run.json" >"$work/lines" 2>"$work/error" &
    run=$!
    : >"$work/said"
    while read -r line; do
        echo "$line" | tee -a "$work/said"
        [[ $line =~ ready ]] && kill -INT $run
        [[ $again && $line =~ parking ]] && sleep 0.4 && kill -INT $run && rm -f "$work/held"
        [[ $line =~ settled ]] && grep -q ready "$work/said" && rm -f "$work/held"
    done <"$work/lines"
    wait $run
    status=$?
    cat "$work/error"
    echo "exit status $status"
    [ $status -eq 1 ] && grep -q 'interrupted: parking' "$work/error" && not_evaluated
}
parks_held_up() { held_up '' && ! grep -q 'test ' "$work/said" && log_is_whole && put_down; }
centres_held_up() { held_up again && grep -q 'interrupted again: valves centred' "$work/error" && ! put_down; }

# The signal comes when the loop has ended by itself, and its last records may still be on their way to the log.
late() {
    ends 143 env LD_PRELOAD="$work/held_up.so" SIGNAL_LATE=yes "${quick[@]}" --set security.confine=false --log "$work/run.lcm" &&
        log_is_whole && put_down
}

# The interrupted phase takes a minute of the run's time, so that the signal comes within it. Parking, the last phase, takes two minutes of
# the run's, about a second of this machine's.
if [ -n "${MORE_CASES:-}" ]; then # make test-long; tests/scenarios/stop.sh sends SIGTERM, too
    claim "SIGTERM in a test: parked, log closed, not evaluated" parks TERM 'test 1/6' tests.duration_s=60
    by_nohup() { local under=(nohup); parks TERM 'test 1/6' tests.duration_s=60; }
    claim "SIGTERM parks under nohup, too" by_nohup
    exit
fi
claim "SIGINT while engaging: parked, log closed, not evaluated" parks INT engaging motion.engage_s=60
claim "SIGINT at neutral: parked, log closed, not evaluated" parks INT ready motion.hold_s=60
claim "SIGINT in a test: parked, log closed, not evaluated" parks INT 'test 1/6' tests.duration_s=60
claim "SIGINT while parking: parked, log closed, not evaluated" parks INT parking motion.park_s=120
claim "SIGHUP in a test, the terminal is gone: the same" parks HUP 'test 1/6' tests.duration_s=60
outlives() { local under=(nohup); ends 0 interrupt_at HUP 'test 1/6' && log_is_whole && put_down; }
claim "under nohup it changes nothing: the run goes on to its end" outlives
claim "SIGINT twice: the valves are centred where the platform is" twice
claim "SIGINT in the first test: no other begins" ends_tests
claim "the reader of its output goes away: the run goes on to its end, and parks" goes_on
in_its_way=("SIGINT while the main thread is held up: parked all the same" "and a second one: the valves are centred"
    "SIGTERM when the run has just ended by itself: the log is closed first")
skip_under 'asan|tsan' "${in_its_way[@]}" "a sanitizer's runtime must be loaded before held_up.so"
claim "${in_its_way[0]}" parks_held_up
claim "${in_its_way[1]}" centres_held_up
claim "${in_its_way[2]}" late
