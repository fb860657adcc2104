#!/bin/bash
# The running daemon's loop thread has no page faults, heap calls or locks from its first deadline to its last (counted by
# tests/rt/counts.c). tests/test_rt_safety.c traps the same and system calls, in more states. No claim depends on how late the loop wakes.
. tests/scenarios/lib
skip_under 'asan|tsan' "a loop without page faults, heap calls and locks" "sanitizers bring their own allocator and locks"
locked=() # as root, at least
[ "$(id -u)" -eq 0 ] || locked=(--unlocked)
counted=("$python" tests/rt/counts.py "${locked[@]}" --)
run=("$hexid" run --hal sim: --rt try "${quick_settings[@]}" --tests x,theta)
mkdir "$work/logs"
claim "the loop meets no page fault, calls no heap and takes no lock while it is recorded in parts" \
    "${counted[@]}" "${run[@]}" --log "$work/logs/" --log-part 0.001
sed 's/^/# /' "$work/claim.out"
claim "nor does it with a fault on the way, and rigid bodies by ODE" \
    "${counted[@]}" "${run[@]}" --hal "fault:nan@2+0.5;sim:" --set sim.engine=ode
sin() { "$python" tests/rt/counts.py --help >/dev/null && sed 's/"loop_thread",/"loop_thread", "recorder_thread"/' tests/rt/counts.py >"$work/counts.py" &&
    "$python" "$work/counts.py" --unlocked -- "${run[@]}" --log "$work/a.lcm"; }
seen() { sin && return 1; grep -q "recorder_thread: .*heap" "$work/claim.out"; }
claim "a thread that calls the heap is seen" seen
