#!/bin/bash
# Commands over LCM: the platform engages, tests and parks when told to, and by default only stops when told to; who set it in motion and goes
# away leaves it parked; what nobody asked for just now does nothing.
. tests/scenarios/lib
own_network "commands over LCM are obeyed"
CLOCK=virtual # the simulated platform's is: no claim is tried again, and the leases are long beside any stall
. tests/scenarios/bus_lib
lcm-gen -p --ppath "$work" lcmtypes/*.lcm

# The run reports to a pipe, on 3, `hexid monitor` to another, on 4.
run= monitor=
start_run() {
    [ -z "$run$monitor" ] || { kill -KILL $run $monitor; wait $run $monitor; } # of a claim that did not come to its end
    rm -f "$work/lines" "$work/monitor"
    mkfifo "$work/lines" "$work/monitor"
    "$hexid" monitor --set lcm.url="$url" >"$work/monitor" &
    monitor=$!
    exec 4<"$work/monitor"
    "$hexid" run --hal sim: --rt off "${quick[@]:5}" --set lcm.url="$url" "$@" --log "$work/run.lcm" --json "$work/run.json" >"$work/lines" 2>"$work/error" &
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
# operate COMMAND: a client in the background, which renews its lease; its process in $operator.
operate() {
    "$hexid" command "$1" --set lcm.url="$url" >"$work/operator.$1" 2>&1 &
    operator=$!
}
ended() { # STATUS
    cat <&3 >"$work/run.ended"
    cat "$work/run.ended"
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
    await settled && operate engage && await ready && tell start && await ready && tell park && await parking && await settled &&
        wait $operator && cat "$work/operator.engage" && grep -q 'now settled' "$work/operator.engage" && kill -INT $run &&
        ended 1 # interrupted, the usual end of a run by hand
}
# gone SIGNAL PATTERN: the operator's client ends so; the run says that, and parks.
gone() {
    start_run --set motion.automatic=false --set lcm.commands=true --set lcm.lease_s=1
    await settled && operate engage && await ready && kill -"$1" $operator && await parking && await settled && kill -INT $run && ended 1 &&
        { [ -z "$2" ] || grep -q "$2" "$work/error"; }
}
unleased() {
    start_run --set motion.automatic=false --set lcm.commands=true --set lcm.lease_s=0
    await settled && tell engage && await ready && tell park && await settled && kill -INT $run && ended 1
}
explained() { # what does nothing says why, and what to do first
    start_run --set motion.automatic=false --set lcm.commands=true
    await settled && ends 4 tell start 2>"$work/why" && grep 'state settled: .*engage' "$work/why" && ends 4 tell reset 2>"$work/why" &&
        grep 'no fault' "$work/why" && tell park >"$work/why" && grep 'nothing moves' "$work/why" && kill -INT $run && ended 1
}
# What was recorded in one session moves nothing in the next: not the requests, and not the old messages without a token.
replayed() {
    lcm-logger --lcm-url="$url" --flush-interval=1 --quiet "$work/session.lcm" >"$work/logger" 2>&1 &
    local logger=$!
    by_hand && kill -INT $logger && wait $logger
    start_run --set motion.automatic=false --set lcm.commands=true
    await settled && PYTHONPATH=$work "$python" - "$work/session.lcm" "$url" <<'END'
import hexid, lcm, sys, time
events = [e for e in lcm.EventLog(sys.argv[1], "r") if e.channel == "HEXID_COMMAND"]
print(len(events), "requests recorded")
bus = lcm.LCM(sys.argv[2])
for event in events:
    if b"engage" in event.data or b"start" in event.data or b"renew" in event.data: bus.publish(event.channel, event.data)
old = hexid.command_t()
old.command = "engage"
for old.time_ns in (-2**63, 0, time.time_ns(), 2**63 - 1): bus.publish("HEXID_COMMAND", old.encode())
sys.exit(len(events) < 3)
END
    [ $? -eq 0 ] && pause 1 && kill -INT $run && ended 1 && ! grep -q engaging "$work/run.ended"
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
    await settled && ends 4 tell engage && kill -INT $run && ended 1 && grep -q 'engage refused: set lcm.commands' "$work/error"
}

fair_claim "engage, start and park by hand" by_hand
fair_claim "a stop ends a test early, and the platform waits at neutral to be parked" stopped
fair_claim "a stop while it rises puts it down, whatever lcm.commands says" turned_back
fair_claim "an operator's client that is killed: its lease runs out, and the platform is parked" gone KILL 'lease has run out'
fair_claim "one that is interrupted parks it" gone INT ''
fair_claim "without a lease the platform stays as it was told" unleased
fair_claim "a command that does nothing says why, and what to do first" explained
fair_claim "a recorded session moves nothing when it is played again, nor do messages without a token" replayed
fair_claim "by default nobody on the network can set the platform in motion" refused
claim "a command that nobody hears is an error" refuses 3 "park nobody $url" tell park
claim "a command that does not exist is refused" refuses 2 "engage, start, stop, park, reset" "$hexid" command jump
