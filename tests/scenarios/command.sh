#!/bin/bash
# Commands over LCM, in real time: the platform engages, tests and parks when told to, and by default only stops when told to.
. tests/scenarios/lib
own_network "commands over LCM are obeyed"
. tests/scenarios/bus_lib

# The real-time run reports to a pipe, on 3, `hexid monitor` to another, on 4. Sanitizers and busy machines miss deadlines here.
run= monitor=
start_run() {
    [ -z "$run$monitor" ] || { kill -KILL $run $monitor; wait $run $monitor; } # of a claim that did not come to its end
    rm -f "$work/lines" "$work/monitor"
    mkfifo "$work/lines" "$work/monitor"
    "$hexid" monitor --set lcm.url="$url" >"$work/monitor" &
    monitor=$!
    exec 4<"$work/monitor"
    "$hexid" run --hal sim: --rt off "${quick[@]:5}" --set lcm.url="$url" --set loop.overrun_limit=100000 --set checks.overruns_pct=100 \
        --set checks.excluded_pct=100 "$@" --log "$work/run.lcm" --json "$work/run.json" >"$work/lines" 2>"$work/error" &
    run=$!
    exec 3<"$work/lines"
}
# await PATTERN [FD]: reads on to a line that matches.
await() {
    while read -r -t 120 -u "${2:-3}" line; do
        echo "$line"
        [[ $line =~ $1 ]] && return
    done
    echo "no line came that matches: $1"
    cat "$work/error"
    return 1
}
tell() { "$hexid" command "$1" --set lcm.url="$url"; }
ended() { # STATUS
    cat <&3
    wait $run
    local status=$?
    kill $monitor
    wait $monitor
    run= monitor=
    cat "$work/error"
    echo "exit status $status"
    [ $status -eq "$1" ]
}

by_hand() {
    start_run --set motion.automatic=false --set lcm.commands=true --tests z
    await settled && tell engage && await ready && tell start && await 'test 1/1' && await ready && tell park && await parking &&
        await settled && kill -INT $run && ended 1 # interrupted, the usual end of a run by hand
}
stopped() {
    start_run --set tests.duration_s=20
    await ready && await ' testing ' 4 && tell stop && await ready && tell park && await parking && ended 1 &&
        "$python" -c 'import json, sys
tests = json.load(open(sys.argv[1]))["tests"]
print(tests)
sys.exit(sum(test["samples"] for test in tests) >= 10000)' "$work/run.json"
}
turned_back() { # without lcm.commands, and more than once
    start_run --set motion.engage_s=60
    await engaging && tell stop && await parking && tell stop && await settled && ended 1
}
refused() {
    start_run --set motion.automatic=false
    await settled && ends 4 tell engage && tell park && kill -INT $run && ended 1 && grep -q 'engage refused' "$work/error" &&
        ! grep -q 'park refused' "$work/error"
}

fair_claim "engage, start and park by hand" by_hand
fair_claim "a stop ends a test early, and the platform waits at neutral to be parked" stopped
fair_claim "a stop while it rises puts it down, whatever lcm.commands says" turned_back
fair_claim "by default nobody on the network can set the platform in motion" refused
claim "a command that nobody hears is an error" refuses 3 "park nobody $url" tell park
claim "a command that does not exist is refused" refuses 2 "engage, start, stop, park, reset" "$hexid" command jump
