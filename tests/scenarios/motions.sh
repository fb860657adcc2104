#!/bin/bash
# hexid run drives motions other than six equal sinusoids: each axis separately, all at once, a trajectory from a file; a motion that the
# machine cannot follow is refused before it starts.
. tests/scenarios/lib
skip_under tsan "other motions" "the threads are those of any run"

# says PATTERN...: true if the last output matches all patterns.
says() { for words in "$@"; do grep -qE -- "$words" "$work/out" || { echo "missing: $words"; cat "$work/out"; return 1; }; done; }
run() { quick "$@" >"$work/out" 2>&1; }

# Two periods of x and theta in 2 s, closed; amplitudes in m and rad.
"$python" - "$work" <<'EOF'
import math, sys
rows = [(0.01 * i, math.pi * 0.02 * i) for i in range(201)]
for name, x, theta in ("small", 0.004, 0.004), ("large", 0.2, 0.0):
    with open(f"{sys.argv[1]}/{name}.csv", "w") as f:
        print("t_s,x_m,theta_rad", file=f)
        for t, a in rows: print(f"{t:.2f},{x * math.sin(a):.9f},{theta * math.sin(a):.9f}", file=f)
EOF

# All axes move at once, each with its own frequency; x and theta in phase would determine less. The motion of 380 s is longer than two
# parts (ANALYSIS_PART_S). Only the noise's share of a deviation shrinks with time.
long() {
    ends 0 run --trajectory "$work/rich.csv" --repeat 3 --json "$work/short.json" &&
    ends 0 run --trajectory "$work/rich.csv" --repeat 190 --log "$work/long.lcm" --json "$work/long.json" && says '^parts +3 of the motion, 0 excluded; 3 groups agree' &&
        ends 0 "$hexid" identify "$work/long.lcm" --json "$work/long_again.json" >/dev/null && cmp "$work/long.json" "$work/long_again.json" &&
        rm "$work/long.lcm" && "$python" -c 'import json, sys
long, short = (json.load(open(f)) for f in sys.argv[1:])
assert long["parts"]["count"] == 3 and long["parts"]["agreement"]["agree"] and "parts" not in short
noise = [r["method_c"]["variance_shares"]["noise"][0][0] ** 0.5 * r["method_c"]["std"][0][0] for r in (long, short)]
assert noise[0] < 0.5 * noise[1], noise' "$work/long.json" "$work/short.json"
}
if [ -n "${MORE_CASES:-}" ]; then # make test-long
    "$python" - "$work/rich.csv" <<'EOF'
import math, sys
own = ("x_m", 0.004, 3), ("y_m", 0.004, 3.5), ("z_m", 0.003, 2.5), ("phi_rad", 0.004, 4), ("theta_rad", 0.004, 4.5), ("psi_rad", 0.004, 5)
with open(sys.argv[1], "w") as f:
    print("t_s", *(name for name, _, _ in own), sep=",", file=f)
    for i in range(801):
        t = 0.0025 * i
        print(t, *(f"{a * math.sin(2 * math.pi * hz * t):.9f}" for _, a, hz in own), sep=",", file=f)
EOF
    claim "a motion of minutes is evaluated part by part, live as from the log, and is surer" long
    exit
fi

own=(--set 'tests.frequency_hz=3,3.5,4,4.5,5,5.5' --set tests.amplitude_m=0.003,0.0035,0.004 --set tests.duration_s=2)
own_frequencies() {
    ends 0 run "${own[@]}" --log "$work/own.lcm" --json "$work/own.json" && "$python" - "$work/own.json" <<'EOF'
import json, sys
d = json.load(open(sys.argv[1]))
assert [t["frequency_hz"] for t in d["tests"]] == [3, 3.5, 4, 4.5, 5, 5.5], d["tests"]
assert [t["amplitude"] for t in d["tests"]] == [0.003, 0.0035, 0.004, 0.006, 0.006, 0.006], d["tests"]
for i in range(6): assert abs(d["method_a"]["Mt"][i][i] / d["nominal"]["Mt"][i][i] - 1) < 0.05, i
EOF
}
claim "each axis its own frequency and amplitude: all six tested, the matrix identified" own_frequencies
again() { ends 0 "$hexid" identify "$work/own.lcm" --json "$work/again.json" >/dev/null && cmp "$work/own.json" "$work/again.json"; }
claim "identify repeats it from the log, to the last bit" again
back() {
    "$hexid" export "$work/own.lcm" -o "$work/csv" >/dev/null && grep -qx '# frequency_hz: 5' "$work/csv/5_theta.csv" &&
        grep -qx '# amplitude: 0.0035' "$work/csv/2_y.csv" && "$hexid" import "$work/csv" -o "$work/back.lcm" >/dev/null &&
        "$hexid" identify "$work/back.lcm" >"$work/out" && says 'verdict +pass'
}
claim "export and import keep it" back
claim "a list that is too short: refused" refuses 2 "tests.frequency_hz 5 6" quick --set tests.frequency_hz=1,2,3,4,5

multisine=(--set tests.multisine=true --set tests.frequency_hz=1.1,1.7,2.3,3.1,3.7,4.3 --set tests.duration_s=12)
# check, gap and identify accept a log of any motion.
of_any_motion() {
    "$hexid" check "$1" >"$work/out" && says '^  none +none ' 'hexid identify would take it' 'hexid gap would take it' &&
        ends 0 "$hexid" identify "$1" --json "$work/any.json" >"$work/out" && says "method C"
}
# At 1 to 4 Hz the coupling's deviation is 2 % with these sensors: below four of those.
at_once() {
    ends 0 run "${multisine[@]}" --log "$work/all.lcm" --json "$work/all.json" && says 'test 1/1 multisine +off by at most' 'verdict +pass' &&
        says 'method C' && "$python" -c 'import json, sys; report = json.load(open(sys.argv[1]))
assert report["tests"] == [] and "method C" in report["verdict"]["scope"] and report["method_c"]["verdict"]["status"] == "pass" and report["method_a"] is None
assert all(abs(e) < 8 for e in report["errors_pct"]["method_c"].values()), report["errors_pct"]["method_c"]' "$work/all.json"
}
claim "a multisine: all axes in one test, and method C has the whole matrix from it" at_once
alike() { run --set tests.multisine=true --set tests.duration_s=1; grep 'warning: tests.multisine: x and y both move at 4 Hz' "$work/out"; }
claim "axes that share a frequency are warned of" alike
claim "check, gap and identify take its log" of_any_motion "$work/all.lcm"
elsewhere() {
    "$hexid" export "$work/all.lcm" -o "$work/all" >/dev/null && "$hexid" import "$work/all" -o "$work/all_back.lcm" >/dev/null &&
        ends 0 "$hexid" identify "$work/all_back.lcm" --json "$work/all_back.json" >"$work/out" && says 'verdict +pass' &&
        "$python" -c 'import json, sys
a, b = (json.load(open(f))["method_c"]["Mt"] for f in sys.argv[1:])
assert all(abs(x / y - 1) < 1e-6 for p, q in zip(a, b) for x, y in zip(p, q) if abs(y) > 1), (a, b)' "$work/all.json" "$work/all_back.json"
}
claim "its CSV, imported, has the same matrix" elsewhere

driven=(--trajectory "$work/small.csv" --repeat 3)
driven() {
    ends 0 run "${driven[@]}" --log "$work/driven.lcm" && says 'test 1/1 trajectory .* 0 of 3000 excluded' 'verdict +pass' &&
        "$hexid" export "$work/driven.lcm" -o "$work/driven" >/dev/null && "$python" - "$work" <<'EOF'
import csv, math, sys
rows = [r for r in csv.reader(l for l in open(f"{sys.argv[1]}/driven/1_none.csv") if l[0] != "#")]
at = {name: rows[0].index(name) for name in ("t_s", "ref_x_m", "ref_y_m", "ref_theta_rad", "phase")}
evaluated = 0
for row in rows[1:]:
    t, x, y, theta, phase = (float(row[at[n]]) for n in ("t_s", "ref_x_m", "ref_y_m", "ref_theta_rad", "phase"))
    assert y == 0
    if phase != 3: continue
    evaluated += 1
    for value in x, theta: assert abs(value - 0.004 * math.sin(2 * math.pi * (t - 0.3))) < 1e-8, (t, value)
assert evaluated == 3000, evaluated
EOF
}
claim "a trajectory: driven as the file has it, three times over" driven
claim "check, gap and identify take its log" of_any_motion "$work/driven.lcm"
same() { run "${driven[@]}" --log "$work/1.lcm" && run "${driven[@]}" --log "$work/2.lcm" && cmp "$work/1.lcm" "$work/2.lcm"; }
claim "the same run twice: the same log, to the last byte" same
moved() { [ ! -e "$work/moved.lcm" ] || { echo "a log was begun"; return 1; }; }
refused() { refuses 2 "$1" quick --log "$work/moved.lcm" "${@:2}" && moved; }
claim "without --trajectory there is none in the log's configuration" grep -q 'trajectory: "" ' <("$hexid" run --print-config)

claim "a multisine beside a trajectory: refused, naming both" refused "tests.multisine tests.trajectory" "${driven[@]}" --set tests.multisine=true
head -n 150 "$work/small.csv" >"$work/open.csv"
claim "a trajectory that does not close: not repeated, with line and remedy" \
    refused "open.csv:150: x_m ends began" --trajectory "$work/open.csv" --repeat 2
printf 't_s,x_mm\n0,0\n' >"$work/mm.csv"
claim "a column of its own: refused, with the line and the columns there are" refused "mm.csv:1: x_mm x_m theta_rad" --trajectory "$work/mm.csv"
printf 't_s,x_m\n0,0\n1,nan\n' >"$work/nan.csv"
claim "no number: refused, with the line" refused "nan.csv:3: x_m" --trajectory "$work/nan.csv"
printf 't_s,x_m\n0,0\n1,0\n1,0\n' >"$work/still.csv"
claim "time that stands still: refused, with the line" refused "still.csv:4: t_s increase" --trajectory "$work/still.csv"
: >"$work/nothing.csv"
claim "an empty file: refused, with what it should have" refused "nothing.csv:0: empty t_s" --trajectory "$work/nothing.csv"
claim "a binary file: refused" refused "hexid:1:" --trajectory "$hexid"
claim "a file that is not there: I/O error, naming it" refuses 3 "none.csv" quick --trajectory "$work/none.csv"
mkfifo "$work/fifo.csv"
claim "a FIFO: refused at once" refuses 3 "fifo.csv FIFO" timeout 10 "${quick[@]}" --trajectory "$work/fifo.csv"
claim "passes of nothing: refused" refused "tests.repeat 3 trajectory" --repeat 3
claim "axes beside a trajectory: refused" refused "tests trajectory" "${driven[@]}" --tests x
claim "passes that are no number: refused" refused "tests.repeat" --trajectory "$work/small.csv" --repeat some

claim "farther and faster than the legs: refused with leg, instant, value, limit and scale" \
    refused "trajectory leg rate m/s limit scale poses 0." --trajectory "$work/large.csv"
claim "axes that are fit alone and not together: refused, with what would do" \
    refused "multisine leg flow scale amplitudes 0." --set tests.multisine=true --set tests.amplitude_m=0.012 --set tests.frequency_hz=6,6.3,6.7,7,7.3,7.7
claim "a valve that is too small: refused, with flow and leg" refused "test leg flow valve_flow_m3_per_s" --set hydraulics.valve_flow_m3_per_s=1e-4
advice() {
    quick --trajectory "$work/large.csv" 2>&1 | sed -n 's/.*scale the poses by \(0\.[0-9]*\).*/\1/p' >"$work/scale" && [ -s "$work/scale" ] &&
        awk -F, -v by="$(cat "$work/scale")" 'NR > 1 { $2 *= by } { print $1 "," $2 "," $3 }' OFS=, "$work/large.csv" >"$work/fit.csv" &&
        quick --print-config --trajectory "$work/fit.csv" >/dev/null && ! quick --trajectory "$work/fit.csv" 2>&1 | grep 'not run'
}
claim "scaled as it says, it is let through" advice
