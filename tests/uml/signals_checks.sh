# Run by tests/uml/run.
. tests/scenarios/lib
. tests/scenarios/bus_lib
lcm-gen -p --ppath "$work" lcmtypes/*.lcm
real=("$hexid" run --hal sim: --rt require "${quick_settings[@]}" --tests z)

# begin SETTING...: in real time up to the middle of a test; $run is its process, its lines come on 3.
begin() {
    local line
    rm -f "$work/lines"
    mkfifo "$work/lines"
    "${real[@]}" "$@" --log "$work/run.lcm" --json "$work/run.json" >"$work/lines" 2>"$work/error" &
    run=$!
    exec 3<"$work/lines"
    while read -r -t 120 -u 3 line; do [[ $line =~ ready ]] && break; done
    pause 1
    kill -0 $run && return
    echo "the run ended before the middle of its test"
    cat <&3 "$work/error"
    return 1
}
# look PYTHON: runs this Python with the log's `cycles`, and the `last` of them.
look() {
    PYTHONPATH=$work "$python" -c 'import hexid, lcm, sys
cycles = [hexid.state_t.decode(e.data) for e in lcm.EventLog(sys.argv[1], "r") if e.channel == "HEXID_STATE"]
last = cycles[-1] if cycles else None
'"$1" "$work/run.lcm"
}

# Delay between the log's last cycle and the loop's: a process that is gone cannot be asked, so a clock is read beside it.
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
        ends 1 "$hexid" identify "$work/run.lcm" >/dev/null # the log is readable but not complete
}

# halted SECONDS: while stopped it can do nothing, so the device's watchdog acts. When it continues, it must not act on old samples.
halted() {
    begin --set tests.duration_s=4 || return
    kill -STOP $run
    pause "$1"
    kill -CONT $run
    cat <&3 >"$work/said"
    cat "$work/said"
    wait $run
    echo "exit status $?"
    grep -A2 'FAULT overrun' "$work/said" | grep -q 'deadlines missed in a row, the longest by' || return
    look 'gap, back = max(((b.time_ns - a.time_ns) / 1e6, b.seq) for a, b in zip(cycles, cycles[1:]))
back = cycles[back]
print("largest gap", gap, "ms; the cycle after it: flags", back.sample_flags, "fault", back.first_fault, "driven", back.enable)
step = max(abs(x - y) for a, b in zip(cycles, cycles[1:]) if a.enable and b.enable for x, y in zip(a.valve, b.valve))
print("largest step of a valve", step)
sys.exit(not (gap >= 900 * '"$1"' and back.sample_flags & 16 and back.first_fault == 128 and not back.enable and not last.enable
              and step < 0.5))'
}

fair_claim "SIGKILL: the log is readable to the last 100 ms" killed
fair_claim "--rt require, stopped for a second: the first cycle after it is a fault, and the valves are centred" halted 1
fair_claim "--rt require, a host that stalls for 40 ms: the same" halted 0.04
ridden_out() { # --rt try
    real=("${real[@]/require/try}")
    begin || return
    kill -STOP $run
    pause 0.04
    kill -CONT $run
    cat <&3 >"$work/said"
    cat "$work/said"
    ! grep -q FAULT "$work/said" && look 'print(last.seq, last.faults); sys.exit(last.faults or any(c.sample_flags & ~128 for c in cycles))' # 128: no pressure yet
}
fair_claim "--rt try: the simulated platform's time stretches, and nothing is faulted or excluded" ridden_out
