#!/bin/bash
# The running daemon has given up unneeded rights, runs on without them, and needs no root to start. tests/test_confine.c covers the
# denials.
. tests/scenarios/lib
skip_under 'asan|tsan' "a confined daemon" "sanitizer builds are not confined"

# running OPTION...: a paced run that has started to move; $run is its process.
running() {
    local line
    rm -f "$work/lines"
    mkfifo "$work/lines"
    "$hexid" run "${quick_settings[@]}" --log "$work/run.lcm" --json "$work/run.json" "$@" >"$work/lines" 2>"$work/error" &
    run=$!
    exec 3<"$work/lines"
    while read -r -t 60 -u 3 line; do [[ $line =~ engaging ]] && return; done
    cat "$work/error"
    return 1
}
ended() {
    kill -INT $run
    cat <&3 >"$work/said"
    wait $run
}
status_of() { cat /proc/$run/task/*/status | sed -n "s/^$1:[[:space:]]*//p"; }

confined() {
    local seccomp privileges rights
    running --rt off || return
    seccomp=$(status_of Seccomp | sort -u) privileges=$(status_of NoNewPrivs | sort -u) rights=$(sed -n 's/^CapPrm:\s*//p' /proc/$run/status)
    ended
    echo "seccomp $seccomp, no new privileges $privileges, rights of the main thread $rights"
    [ "$seccomp $privileges" = "2 1" ] && [[ $rights =~ ^0+$ ]] && [ -s "$work/run.json" ]
}
claim "all threads of a paced run are confined, and its result is written" confined

same_result() {
    quick --json "$work/confined.json" >/dev/null 2>"$work/error" && ! [ -s "$work/error" ] &&
        quick --json "$work/free.json" --set security.confine=false >/dev/null 2>"$work/warned" &&
        diff "$work/confined.json" "$work/free.json" && grep 'security.confine is off' "$work/warned"
}
claim "a fast run gives the same bytes; where it is off, that is said" same_result
claim "a result to standard output" eval 'quick --json - 2>/dev/null | grep -q hexid.identification/1'

denied_nothing() {
    strace -f -o "$work/calls" "$hexid" run --fast "${quick_settings[@]}" --log "$work/run.lcm" --json "$work/run.json" >/dev/null &&
        ! grep 'EPERM' "$work/calls"
}
if command -v strace >/dev/null; then claim "and asks for nothing that it is denied" denied_nothing; fi

# The kernel denies the filter while the loop already runs: the long first test must not be completed.
unconfined() {
    ends 4 strace -f -o "$work/calls" -e trace=seccomp -e inject=seccomp:error=ENOMEM \
        "$hexid" run --fast "${quick_settings[@]}" --set tests.duration_s=20 >"$work/said" 2>"$work/error"
    local status=$?
    cat "$work/said" "$work/error"
    ((status == 0)) && grep -q 'cannot be confined: .*security.confine=false' "$work/error" && ! grep -q 'test [1-6]/6' "$work/said"
}
if command -v strace >/dev/null; then claim "a run that cannot be confined is parked and ends, refused" unconfined; fi

# A service's rights: a user with only the two for real time.
text="as nobody, with CAP_SYS_NICE and CAP_IPC_LOCK alone: --rt require on sim:"
rights=(setpriv --reuid nobody --regid nogroup --clear-groups --inh-caps -all,+sys_nice,+ipc_lock --ambient-caps -all,+sys_nice,+ipc_lock
    --bounding-set -all,+sys_nice,+ipc_lock)
unprivileged() {
    chmod 755 "$work"
    mkdir -m 777 "$work/theirs"
    cp "$hexid" "$work/hexid"
    hexid="${rights[*]} $work/hexid"
    # A busy host may miss deadlines here, and the verdict may report that.
    $hexid run --rt require "${quick_settings[@]}" --set limits.blind_time_s=10 --set loop.overrun_limit=4000 \
        --log "$work/theirs/run.lcm" --json "$work/theirs/run.json" >"$work/theirs/said" 2>&1
    local status=$?
    cat "$work/theirs/said"
    ((status <= 1)) && grep -q '6/6 psi' "$work/theirs/said" && ! grep -Eq 'warning|FAULT' "$work/theirs/said" && [ -s "$work/theirs/run.json" ]
}
if [ "$(id -u)" -ne 0 ]; then
    echo "ok - $text # SKIP only root can give these rights to another user"
elif ! chrt -f 80 true 2>/dev/null; then
    echo "ok - $text # SKIP this machine has no SCHED_FIFO"
else
    claim "$text" unprivileged
fi
