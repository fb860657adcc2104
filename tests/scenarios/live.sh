#!/bin/bash
# The live page in a headless Chromium, with a hexid that runs by the wall clock; and hexid monitor in a terminal and a pipe.
. tests/scenarios/lib
own_network "the live page"
skip_under tsan "the live page" "one thread"

live() { "$python" tests/scenarios/live.py "$1" "$work" "$hexid" "$url"; }
monitor() { "$hexid" monitor --set lcm.url="$url" "$@"; }
"$python" tests/scenarios/axis.py 80 1 >"$work/stand.csv"
"$hexid" import "$work/stand.csv" -c config/axis.yaml -o "$work/axis.lcm" >"$work/import" 2>&1

claim "it draws the platform, strips, tests and matrix, at 1200 and 420 px, light and dark, and loads nothing from elsewhere" live draws
claim "a fault and its remedy are on it within a second" live fault
claim "it goes on when hexid starts again, and when its own server does" live restarts
claim "a single cylinder is shown in its own words" live cylinder
claim "it is read only, for its own names only, and survives requests that are none" live requests
claim "readers that do not read hold up neither another nor LCM, nor does the server grow" live slow
claim "few messages make lines too, and a reader too many is told so and let in later" live sparse
claim "what strangers send is text" live strangers

claim "a port that is none is refused" refuses 2 "--http 127.0.0.1:65536 8321" monitor --http 127.0.0.1:65536
claim "an address that is not this host's is refused" refuses 3 "192.0.2.1:8321 address" monitor --http 192.0.2.1:8321
claim "a name that nobody knows is refused" refuses 3 "nowhere.invalid host" monitor --http nowhere.invalid:8321
claim "--http with --once is refused" refuses 2 "--http --once" monitor --http 8321 --once
taken() {
    mkfifo "$work/first" && { "$hexid" monitor --set lcm.url="$url" --http 127.0.0.1:0 >"$work/first" & }
    local first=$! where
    read -r where <"$work/first"
    where=${where##*http://}
    refuses 3 "${where%/} another" monitor --http "${where%/}"
    local status=$?
    kill $first && wait $first && return $status
}
claim "a port that is taken is refused" taken
warned() {
    "$hexid" monitor --set lcm.url="$url" --http 0.0.0.0:0 >"$work/wide" 2>"$work/warned" &
    local wide=$!
    until [ -s "$work/warned" ] || ! kill -0 $wide; do sleep 0.05; done
    kill $wide
    wait $wide
    cat "$work/warned"
    grep -q 'warning: 0.0.0.0 is no loopback address' "$work/warned"
}
claim "an address that others reach is served with a warning" warned

nobody() { refuses 3 "no hexid was heard lcm.url" monitor --once; }
claim "--once without a hexid: an error after 3 s" nobody
"$hexid" run --rt off "${quick_settings[@]}" --set lcm.url="$url" >"$work/run" 2>&1 &
run=$!
once() {
    # under a sanitizer on a busy host its start alone may take seconds
    for ((i = 0; i < 600; i++)); do
        ! grep -q engaging "$work/run" || break
        sleep 0.1
    done
    monitor --once >"$work/once" && cat "$work/once" && grep -q "leg length m" "$work/once" &&
        grep -Eq '^  6 .*\[ *#*\|#* *\]$' "$work/once" &&
        ! grep -E '.{81}' "$work/once"
}
claim "--once prints the newest state, with bars, in 80 columns" once
once_json() { monitor --once --json | "$python" -c 'import json, sys
lines = sys.stdin.readlines()
assert len(lines) == 1 and json.loads(lines[0])["channel"] == "HEXID_STATE" and "force_6_n" in lines[0]'; }
claim "--once --json: one object" once_json
lines() { timeout 60 "$hexid" monitor --set lcm.url="$url" --json | "$python" -c 'import json, sys
seen = set()
for n, line in enumerate(sys.stdin):
    seen.add(json.loads(line)["channel"])
    if n > 20 and {"HEXID_STATE", "HEXID_LOOP_STATS"} <= seen: sys.exit()
sys.exit("ended before")'; }
claim "--json: an object a line" lines
piped() { # one state per second, whatever the rate on the wire
    timeout 60 "$hexid" monitor --set lcm.url="$url" | "$python" -c 'import sys, time
states, results = [], 0
for line in sys.stdin:
    print(line, end="")
    if "  fault none  x " in line: states.append(time.monotonic())
    results += " result " in line
    if len(states) > 2 and results: sys.exit(states[2] - states[0] < 1.5)
sys.exit("ended before")'
}
claim "in a pipe a state a second, and results as they come" piped
drawn() { # redrawn in place: the cursor moves up by the nine lines of the view
    timeout 3 script -qc "$hexid monitor --set lcm.url=$url" /dev/null </dev/null >"$work/drawn"
    [ "$(grep -c $'\033\[9A' "$work/drawn")" -ge 3 ] && tr -d '\r' <"$work/drawn" | sed $'s/\033\\[[0-9]*[AJ]//g' | grep '^  leg length m'
}
claim "on a terminal the view is redrawn in place" drawn
{ kill -KILL $run && wait $run; } 2>/dev/null || true
