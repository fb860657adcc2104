#!/bin/bash
# Foreign LCM messages neither end a monitor nor control its terminal.
. tests/scenarios/lib
own_network "a monitor survives hostile messages"

"$hexid" monitor --set lcm.url="$url" >"$work/monitor" 2>"$work/error" &
monitor=$!
until [ "$(listeners)" -ge 1 ] || ! kill -0 $monitor; do sleep 0.02; done
"$python" tests/peers/hostile.py "$work" "$url" >"$work/sent" 2>&1
for _ in $(seq 500); do grep -q 'last one' "$work/monitor" && break; kill -0 $monitor 2>/dev/null || break; sleep 0.02; done

survives() {
    cat -v "$work/sent" "$work/monitor" "$work/error"
    grep -q 'note: the last one' "$work/monitor" && kill -0 $monitor
}
harmless() {
    cat -v "$work/monitor"
    grep -q 'no?\[2Jte: a?31m??b' "$work/monitor" && grep -q 'result x?\]0;title?:' "$work/monitor" &&
        ! grep -q $'[\001-\010\013-\037\177]' "$work/monitor"
}
claim "a monitor survives hostile messages" survives
claim "what a terminal would obey is shown as text" harmless
kill $monitor
wait $monitor || true # ended by the signal
