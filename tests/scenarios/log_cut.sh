#!/bin/bash
# A log that is truncated anywhere or damaged is read up to there, and that is reported.
. tests/scenarios/lib

quick --tests x,psi --log "$work/whole.lcm" >"$work/run" 2>&1
size=$(stat -c %s "$work/whole.lcm")

# Prints the number of evaluated samples that identify finds in a log.
samples() {
    "$hexid" identify "$1" --json - 2>"$work/error" |
        "$python" -c 'import json, sys; print(sum(t["samples"] for t in json.load(sys.stdin)["tests"]))'
}

cut_everywhere() {
    local before=0 now cut
    for part in $(seq 1 40); do
        cut=$((size * part / 41 + part))
        # A cut between two events leaves a whole log, so it is moved: every event begins with this word.
        [ "$(od -An -tx1 -j $cut -N 4 "$work/whole.lcm" | tr -d ' ')" = eda1da01 ] && cut=$((cut + 5))
        head -c $cut "$work/whole.lcm" >"$work/cut.lcm"
        now=$(samples "$work/cut.lcm")
        echo "cut at byte $cut of $size: $now samples; $(cat "$work/error")"
        grep -q "cut.lcm.*byte" "$work/error" || return 1
        ((now >= before)) || return 1
        before=$now
    done
    ((before > 0))
}

cut_in_first_event() {
    for cut in 1 27 28 100; do
        head -c $cut "$work/whole.lcm" >"$work/cut.lcm"
        refuses 3 cut.lcm "$hexid" identify "$work/cut.lcm" || return 1
    done
}

# Bytes overwritten in the middle: never more samples than before, never a crash (status 126 and up).
damaged() {
    local whole now at status
    whole=$(samples "$work/whole.lcm")
    for part in $(seq 1 20); do
        at=$((size * part / 21))
        cp "$work/whole.lcm" "$work/damaged.lcm"
        printf '\377\376\375\374' | dd of="$work/damaged.lcm" bs=1 seek=$at conv=notrunc status=none
        "$hexid" identify "$work/damaged.lcm" >/dev/null 2>"$work/error"
        status=$?
        echo "damaged at byte $at: status $status; $(cat "$work/error")"
        ((status == 1 || status == 3)) || return 1
        now=$(samples "$work/damaged.lcm")
        ((now <= whole)) || return 1
    done
}

# No signal handler runs, so the log contains what the recorder had written. The five tests left when it is killed are minutes of the run's
# time and seconds of this machine's.
killed() {
    local run status
    mkfifo "$work/lines"
    "${quick[@]}" --set tests.duration_s=60 --log "$work/killed.lcm" >"$work/lines" &
    run=$!
    grep -m 1 'test 1/6' "$work/lines"
    kill -KILL $run
    wait $run
    status=$?
    ((status == 137)) || { echo "exit status $status: the run ended before it was killed"; return 1; }
    samples "$work/killed.lcm"
    [ "$(samples "$work/killed.lcm")" -ge 24000 ] # the first test has 30000
}

claim "a log cut anywhere is read up to the cut, and the cut is named" cut_everywhere
claim "a log cut in its first event is refused" cut_in_first_event
claim "a damaged log is read as far as it is sound" damaged
claim "a run that was killed leaves its log readable" killed
