#!/bin/bash
# The daemon killed, and the daemon stopped: in real time, as the system would do it.
# Runs alone.
. tests/scenarios/lib
. tests/scenarios/realtime_lib
lcm-gen -p --ppath "$work" lcmtypes/*.lcm
# A busy machine may miss deadlines for 0.2 s; stopped for a second is more.
real=("$hexid" run --hal sim: --rt off "${quick[@]:5}" --set loop.overrun_limit=100 --tests z)

# begin SETTING...: in real time up to the middle of a test; $run is its process, its lines come on 3.
begin() {
    local line
    rm -f "$work/lines"
    mkfifo "$work/lines"
    "${real[@]}" "$@" --log "$work/run.lcm" --json "$work/run.json" >"$work/lines" 2>"$work/error" &
    run=$!
    exec 3<"$work/lines"
    while read -r -t 120 -u 3 line; do [[ $line =~ ready ]] && break; done
    until [ "$(seconds)" -gt 3 ]; do
        kill -0 $run || { echo "the run ended before the middle of its test"; cat <&3 "$work/error"; return 1; }
    done
}
# Whole seconds of the loop's time in the log so far.
seconds() { look 'print(int(last.time_ns // 10**9) if last else 0)'; }
# look PYTHON: with `cycles`, and `last` of them.
look() {
    PYTHONPATH=$work "$python" -c 'import hexid, lcm, sys
cycles = [hexid.state_t.decode(e.data) for e in lcm.EventLog(sys.argv[1], "r") if e.channel == "HEXID_STATE"]
last = cycles[-1] if cycles else None
'"$1" "$work/run.lcm"
}

# What the log lacks of the loop's last cycle: none of it can be asked of a process that is gone, so a clock is read beside it.
killed() {
    local killed_us status
    begin --set tests.duration_s=20 || return
    kill -KILL $run
    killed_us=${EPOCHREALTIME/./}
    wait $run
    status=$?
    ((status == 137)) || { echo "exit status $status: the run ended before it was killed"; cat <&3 "$work/error"; return 1; }
    PYTHONPATH=$work "$python" -c 'import hexid, lcm, sys
events = [e for e in lcm.EventLog(sys.argv[1], "r")]
states = [hexid.state_t.decode(e.data) for e in events if e.channel == "HEXID_STATE"]
gaps = [b.seq - a.seq for a, b in zip(states, states[1:])]
missing_ms = (int(sys.argv[2]) - [e for e in events if e.channel == "HEXID_STATE"][-1].timestamp) / 1000
print(len(states), "cycles, the last", missing_ms, "ms before the kill, largest step of seq", max(gaps))
sys.exit(missing_ms > 100)' "$work/run.lcm" "$killed_us" &&
        ends 1 "$hexid" identify "$work/run.lcm" >/dev/null # readable, and not complete
}

# Stopped for a second, it can do nothing: that is for the device's watchdog. Going on, it must not act on what is past.
stopped() {
    begin --set tests.duration_s=4 || return
    kill -STOP $run
    sleep 1
    kill -CONT $run
    cat <&3
    wait $run
    echo "exit status $?"
    look 'gap, back = max(((b.time_ns - a.time_ns) / 1e6, b.seq) for a, b in zip(cycles, cycles[1:]))
back = cycles[back]
print("largest gap", gap, "ms; the cycle after it: flags", back.sample_flags, "fault", back.first_fault, "driven", back.enable)
step = max(abs(x - y) for a, b in zip(cycles, cycles[1:]) if a.enable and b.enable for x, y in zip(a.valve, b.valve))
print("largest step of a valve", step)
sys.exit(not (gap >= 900 and back.sample_flags & 16 and back.first_fault == 128 and not back.enable and not last.enable and step < 0.5))'
}

fair_claim "SIGKILL: the log is readable to the last 100 ms" killed
fair_claim "SIGSTOP for a second: the first cycle after it is a fault, and the valves are centred" stopped
