#!/bin/bash
# Commands: the platform engages, tests and parks on command, and by default only stops on command. If a client that set it in motion
# leaves, the platform is parked. Over LCM, stop and park are accepted and motion is not.
. tests/scenarios/lib
own_network "commands are obeyed"
CLOCK=virtual # the simulated platform's clock: no claim is repeated, and the leases are long compared with any stall
. tests/scenarios/bus_lib
lcm-gen -p --ppath "$work" lcmtypes/*.lcm

# The run writes to a pipe, on 3, `hexid monitor` to another, on 4.
run= monitor=
start_run() {
    [ -z "$run$monitor" ] || { kill -KILL $run $monitor; wait $run $monitor; } # left over from a claim that broke off
    rm -f "$work/lines" "$work/monitor"
    mkfifo "$work/lines" "$work/monitor"
    "$hexid" monitor --set lcm.url="$url" >"$work/monitor" &
    monitor=$!
    exec 4<"$work/monitor"
    "$hexid" run --hal sim: --rt off "${quick[@]:5}" --set lcm.url="$url" "$@" --log "$work/run.lcm" --json "$work/run.json" >"$work/lines" 2>"$work/error" &
    run=$!
    exec 3<"$work/lines"
}
# await PATTERN [FD]: reads up to a line that matches.
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
# operate COMMAND: a client in the background that renews its lease; its process is in $operator.
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
# gone SIGNAL PATTERN: the operator's client ends or stops by SIGNAL; the run reports PATTERN and parks.
gone() {
    start_run --set motion.automatic=false --set lcm.commands=true --set lcm.lease_s=1
    await settled && operate engage && await ready && kill -"$1" $operator && await parking && await settled && kill -INT $run && ended 1 &&
        { [ -z "$2" ] || grep -q "$2" "$work/error"; }
    local status=$?
    kill -KILL $operator 2>/dev/null
    return $status
}
unleased() {
    start_run --set motion.automatic=false --set lcm.commands=true --set lcm.lease_s=0
    await settled && tell engage && await ready && tell park && await settled && kill -INT $run && ended 1
}
explained() { # a command without effect states the reason and the command to give first
    start_run --set motion.automatic=false --set lcm.commands=true
    await settled && ends 4 tell start 2>"$work/why" && grep 'state settled: .*engage' "$work/why" && ends 4 tell reset 2>"$work/why" &&
        grep 'no fault' "$work/why" && tell park >"$work/why" && grep 'nothing moves' "$work/why" && kill -INT $run && ended 1
}
# Messages over LCM, a recorded session's included, never cause motion, and a stop stops.
over_lcm() {
    start_run --set motion.automatic=false --set lcm.commands=true
    await settled && PYTHONPATH=$work "$python" - "$url" <<'END' && pause 0.5 && operate engage && await ready && say_park && await parking && await settled &&
import hexid, lcm, sys, time
bus = lcm.LCM(sys.argv[1])
request, command = hexid.request_t(), hexid.command_t()
for word in ("engage", "start", "reset", "renew"):
    request.command = command.command = word
    for request.token in (0, 1, -1, 2**63 - 1):
        request.id = 7
        bus.publish("HEXID_COMMAND", request.encode())
    for command.time_ns in (-2**63, 0, time.time_ns(), 2**63 - 1): bus.publish("HEXID_COMMAND", command.encode())
END
        kill -INT $run && ended 1 && [ "$(grep -c engaging "$work/run.ended")" -eq 0 ]
}
say_park() {
    PYTHONPATH=$work "$python" -c 'import hexid, lcm, sys
command = hexid.command_t()
command.command = "park"
lcm.LCM(sys.argv[1]).publish("HEXID_COMMAND", command.encode())' "$url"
}
stopped() {
    start_run --set tests.duration_s=20
    await ready && await ' testing ' 4 && tell stop && await ready && tell park && await parking && ended 1 &&
        "$python" -c 'import json, sys
tests = json.load(open(sys.argv[1]))["tests"]
print(tests)
sys.exit(sum(test["samples"] for test in tests) >= 10000)' "$work/run.json"
}
turned_back() { # a stop is accepted without lcm.commands, and more than once
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
fair_claim "an operator's client that is killed: its connection ends, and the platform is parked" gone KILL 'connection has ended'
fair_claim "one that hangs: its lease runs out, and the platform is parked" gone STOP 'lease has run out'
fair_claim "one that is interrupted parks it" gone INT ''
fair_claim "without a lease the platform stays as it was told" unleased
fair_claim "a command that does nothing says why, and what to do first" explained
fair_claim "nothing that is said over LCM sets the platform in motion, and a park puts it down" over_lcm
fair_claim "by default nobody can set the platform in motion" refused
claim "a command that nobody hears is an error, and a stop is tried over LCM, too" refuses 3 "park nobody $HEXID_RUNTIME_DIR LCM emergency" tell park
claim "a command that does not exist is refused" refuses 2 "engage, start, stop, park, reset" "$hexid" command jump
