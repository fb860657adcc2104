#!/bin/bash
# hexid check describes any recording and says whether gap and identify would accept it; it refuses only unreadable ones.
. tests/scenarios/lib
skip_under tsan "hexid check" "one thread"

quick --set tests.settle_s=1 --set tests.duration_s=2 --log "$work/run.lcm" >/dev/null 2>&1
"$hexid" export "$work/run.lcm" -o "$work/csv" >/dev/null
check() { "$hexid" check "$@" >"$work/text"; }
says() { for words in "$@"; do grep -qE -- "$words" "$work/text" || { echo "missing: $words"; cat "$work/text"; return 1; }; done; }
# fact JSON EXPRESSION: a Python expression about d, the JSON, and t, its first test.
fact() { "$python" -c 'import json, sys
d = json.load(open(sys.argv[1])); t = d["tests"][0]
print(json.dumps(d)[:2000])
sys.exit(not eval(sys.argv[2]))' "$@"; }

of_a_log() {
    ends 0 check "$work/run.lcm" --json "$work/a.json" && ! says 'before the motion is steady' >/dev/null && says '^  x .* 4 +[34]\.[0-9]+ ' 'psi: rest .* moving .* steady .* at [34]\.' 'hexid gap would take it' &&
        ! grep -E '.{81}' "$work/text" && fact "$work/a.json" 'd["schema"] == "hexid.check/1" and len(d["tests"]) == 6 and d["gap"]["taken"]' &&
        fact "$work/a.json" 't["rows"] > 1500 and abs(t["rate_hz"] - 500) < 0.01 and t["lost"] == 0 and abs(t["measured_hz"] - 4) < 0.01' &&
        fact "$work/a.json" '[p["kind"] for p in d["tests"][5]["pieces"]][:3] == ["rest", "moving", "steady"]' &&
        fact "$work/a.json" 'abs(t["channels"]["length"]["step"] - 5e-5) < 1e-9 and t["channels"]["p1"]["there"] == [1, 2, 3, 4, 5, 6]'
}
claim "of a log: rate, frequency, pieces, channels, sensor step; gap would take it" of_a_log

claim "a verdict of fail is no refusal" eval \
    'ends 0 check "$work/run.lcm" --set checks.force_wander_n=0.1 --json "$work/a.json" && says "hexid identify would take it, with the verdict fail: test x:" &&
        fact "$work/a.json" "d[\"identify\"][\"taken\"] and \"wandered\" in d[\"identify\"][\"reason\"]"'

of_its_csv() {
    ends 0 check "$work/csv" --json "$work/b.json" && says '^  1_x.csv' && "$python" -c 'import json, sys
a, b = (json.load(open(f))["tests"] for f in sys.argv[1:])
for x, y in zip(a, b, strict=True):
    for key in ("axis", "rows", "measured_hz", "amplitude", "channels"): assert x[key] == y[key], (key, x[key], y[key])' \
        "$work/a.json" "$work/b.json"
}
claim "a directory of CSV shows what its log shows, without an import" of_its_csv
nothing_left() { TMPDIR=$work/tmp; mkdir "$TMPDIR"; TMPDIR=$TMPDIR "$hexid" check "$work/csv" >/dev/null; [ -z "$(ls -A "$work/tmp")" ]; }
claim "and leaves nothing behind" nothing_left

page() {
    ends 0 check "$work/run.lcm" -o "$work/page.html" && ! grep -qE '<script|(src|href)="[^d]' "$work/page.html" &&
        [ "$(grep -o '<img alt=' "$work/page.html" | wc -l)" -eq 6 ] && grep -q '<p>areas of the pressures' "$work/page.html" &&
        ! grep -q 'class="notice"' "$work/page.html" &&
        chromium --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --user-data-dir="$work/chromium" --window-size=1240,1300 \
            --screenshot="$work/page.png" "file://$work/page.html" >/dev/null 2>&1 && [ "$(stat -c %s "$work/page.png")" -gt 100000 ]
}
claim "its page has a picture for each test, stands alone, and a browser draws it" page
no_gnuplot() { PATH=/nowhere "$hexid" check "$work/run.lcm" -o "$work/plain.html" >/dev/null 2>"$work/error"; }
without_gnuplot() { ends 3 no_gnuplot && grep -q gnuplot-nox "$work/error" && grep -q 'picture not drawn' "$work/plain.html"; }
claim "without gnuplot the page is written without pictures, and the status says so" without_gnuplot

# Another user's rig: own names, decimal commas, half a second lost, rest, 3 Hz, rest.
mkdir "$work/rig"
"$python" - "$work/rig/Versuch 1.csv" <<'END'
import math, random, sys
random.seed(1)
with open(sys.argv[1], "w") as f:
    f.write("Zeit;Kolben Länge (mm);Kraft;Öl [°C]\n")
    for i in range(14000):
        t = i / 1000
        if 9.0 < t < 9.5: continue
        x = 5 * math.sin(2 * math.pi * 3 * (t - 2)) if 2 < t < 12 else 0
        f.write(f"{t:.3f};{round((x + random.gauss(0, 0.01)) / 0.02) * 0.02:.2f};{-0.4 * x + random.gauss(0, 0.01):.4f};40\n".replace(".", ","))
END
map='t=Zeit,position=Kolben Länge (mm),force=Kraft:kN'
rig() { check "$work/rig" -c config/axis.yaml --set loop.period_s=0.001 "$@"; }
of_a_foreign_rig() {
    rig --map "$map" --json "$work/c.json"
    says 'rest 2' 'steady .* at 3' 'not understood and left out:.*Öl' &&
        fact "$work/c.json" '[p["kind"] for p in t["pieces"]] == ["rest", "steady", "rest"] and t["lost"] == 499 and t["longest_gap_s"] == 0.5' &&
        fact "$work/c.json" 'abs(t["measured_hz"] - 3) < 1e-3 and t["mechanism"] == "axis" and abs(t["amplitude"] - 5e-3) < 1e-4' &&
        fact "$work/c.json" 'abs(t["channels"]["length"]["step"] - 2e-5) < 1e-9 and abs(t["channels"]["force"]["greatest"] - 2e3) < 100'
}
claim "of a foreign rig's columns by --map: pieces, loss, frequency in truth, sensor step" of_a_foreign_rig
claim "gap would take it, rests and all" eval 'ends 0 rig --map "$map" && says "hexid gap would take it"'
claim "gap's very refusal is said: the middle is not the configuration's" eval \
    'ends 1 rig --map "$map" --set axis.middle_m=0.3 && says "hexid gap would refuse it: the position runs"'
claim "a name that no file has is refused with those left over" refuses 2 "Krafft force_n Kraft" rig --map "${map/Kraft/Krafft}"
# Even with a long name no row is taller than four lines.
phone() {
    mkdir "$work/long" && cp "$work/rig/Versuch 1.csv" "$work/long/Versuch 1 mit der alten Pumpe, Ventil 3 warm.csv" &&
        check "$work/long" -c config/axis.yaml --set loop.period_s=0.001 --map "$map" -o "$work/long.html" >/dev/null &&
        "$python" tests/scenarios/narrow.py "$work/long.html" "$work" && "$python" - "$work" <<'END'
import pathlib, sys
sys.path.insert(0, "tests/peers")
from browser import Browser
with Browser(sys.argv[1]) as page:
    page.size(420, 900)
    page.open(pathlib.Path(sys.argv[1], "long.html").as_uri())
    rows = page.evaluate("[...document.querySelectorAll('tr')].map(row => row.getBoundingClientRect().height)")
print(rows)
assert max(rows) < 100, rows
END
}
claim "its page on a phone: no wider than the window, no row taller than four lines" phone
claim "a unit that the column cannot have is refused" refuses 2 "position_m bar mm" rig --map "t=Zeit,position=Kolben Länge (mm):bar"
claim "--map of a log is refused" refuses 2 "--map run.lcm" "$hexid" check "$work/run.lcm" --map "$map"

free_motion() {
    mkdir -p "$work/free"
    sed 's/^# dof: .*/# dof: none/' "$work/csv/1_x.csv" >"$work/free/1.csv"
    ends 0 check "$work/free" --json "$work/d.json" && says '^  1.csv +none' 'steady' 'gap would take it' &&
        fact "$work/d.json" 't["axis"] == "none" and t["stated_hz"] is None and t["rows"] > 1500 and abs(t["measured_hz"] - 4) < 0.01'
}
claim "a recording of any motion, dof: none, is shown" free_motion
# Foreign data: without phases, and the logger's time continues from file to file.
runs_on() {
    mkdir -p "$work/on"
    for file in "$work"/csv/*.csv; do
        name=${file##*/}
        awk -F, -v OFS=, -v more="${name%%_*}00" '/^#/ { print; next } /^t_s/ { NF -= 2; print; next } { NF -= 2; $1 = sprintf("%.3f", $1 + more); print }' \
            "$file" >"$work/on/$name"
    done
    cp "$work/csv/config.yaml" "$work/on"
    ends 0 check "$work/on" --json "$work/g.json" && says 't = 0, found by the motion, at t_s = 1_x.csv: (99.[89]|100.[01]).*2_y.csv' 'hexid gap would take it' 'hexid identify would take it' &&
        fact "$work/g.json" 'd["left_out"] == "" and "6_psi.csv: " in d["zero"]' &&
        "$hexid" import "$work/on" -o "$work/on.lcm" >"$work/text" && says 't_s does not begin near t = 0' &&
        "$hexid" identify "$work/on.lcm" >"$work/text" && says 'verdict   pass'
}
claim "time that runs on from file to file begins with each test's motion" runs_on
left_out() {
    cp -r "$work/csv" "$work/settled" && sed -i '/^[-0-9]/s/,[0-9]*$/,0/' "$work/settled/2_y.csv"
    ends 0 check "$work/settled" --json "$work/h.json" && says 'hexid gap excludes, .*' ' y$' && fact "$work/h.json" 'd["left_out"] == "y"' &&
        "$hexid" import "$work/settled" -o "$work/settled.lcm" >/dev/null && { "$hexid" identify "$work/settled.lcm" >"$work/text"; says 'test y excluded: no sample is in the evaluated part'; }
}
claim "a test without a sample to evaluate is not excluded in silence" left_out
of_which_log() {
    local both=("$work/run.lcm" "$work/settled.lcm")
    ends 0 check "${both[@]}" --json "$work/h.json" && fact "$work/h.json" 'd["left_out"].endswith("settled.lcm: y") and "run.lcm" not in d["left_out"]' &&
        ends 3 "$hexid" gap --measured "${both[0]}" --measured "${both[1]}" -c "$work/csv/config.yaml" -o /nowhere/gap 2>"$work/error"
    cat "$work/error"
    grep -q 'settled.lcm: excluded, .* y$' "$work/error" && ! grep -q 'run.lcm: excluded' "$work/error"
}
claim "and of several logs it is said of which" of_which_log
turned() {
    mkdir -p "$work/turned" && cp "$work"/csv/* "$work/turned" && awk -F, -v OFS=, '/^[-0-9]/ { $6 = -$6 } { print }' "$work/csv/5_theta.csv" >"$work/turned/5_theta.csv"
    ends 1 check "$work/turned" && says 'test theta: all legs move against' 'ref_theta_rad'
}
claim "a reference of a wrong sign is named" turned

# The recording's ramp takes a second, whatever the header states.
ramp() {
    for ramp_s in 0.3 1.4; do
        mkdir -p "$work/ramp" && "$python" tests/scenarios/axis.py 80 1 | sed "1i # ramp_s: $ramp_s" >"$work/ramp/1.csv"
        ends 0 check "$work/ramp" -c config/axis.yaml --json "$work/i.json" -o "$work/i.html" || return 1
        [ $ramp_s = 1.4 ] && break
        says '! 1.csv: the evaluated part begins at 0.3 s, before the motion is steady' 'ramp_s must be at least 1.4' && grep -q 'ramp: the evaluated part begins at 0.3 s' "$work/i.html" &&
            fact "$work/i.json" '1.0 < t["ramp_least_s"] <= 1.4' || return 1
    done
    ! grep -q 'before the motion is steady' "$work/text" && fact "$work/i.json" 't["ramp_least_s"] is None'
}
claim "a ramp that is longer than ramp_s is said, and how long that must be" ramp

apart() {
    cp -r "$work/csv" "$work/apart" && sed -i 's/^# frequency_hz: .*/# frequency_hz: 5/' "$work/apart/2_y.csv" && rm "$work/apart/config.yaml" &&
        echo "nothing" >"$work/apart/9.csv"
    ends 1 check "$work/apart" 2>"$work/error" && says '^  1_x.csv' '^  2_y.csv .* 5 +[34]\.' '^  6_psi.csv' 'hexid gap would refuse it' && grep -q 9.csv "$work/error"
}
claim "files that import refuses together are shown one by one" apart

dead() {
    mkdir -p "$work/dead"
    awk -F, -v OFS=, '/^#/ || /^t_s/ { print; next } { $16 = 3e6; if ($20 > 7e6) $20 = 7e6; n++ } n % 50 { print }' "$work/csv/1_x.csv" >"$work/dead/1_x.csv"
    check "$work/dead" --json "$work/e.json" -o "$work/dead.html"
    says 'p1 of leg 3 never changes' && grep -q '<td>p1</td>.*<span class="notice">3</span>' "$work/dead.html" && fact "$work/e.json" 't["channels"]["p1"]["dead"] == [3]' && fact "$work/e.json" 't["lost"] > 20'
}
claim "a dead channel and lost rows are found" dead

escape=$'\033[2J\a\302\233'
hostile() {
    mkdir -p "$work/hostile" "$work/empty" "$work/void"
    : >"$work/void/1.csv"
    : >"$work/void.lcm"
    { echo "# dof: none"; echo "# rate_hz: 1000"; echo "t_s,l1_m,l2_m,${escape}"; for n in 0 1 2 3 4 5 6 7 8 9; do echo "0.00$n,nan,1.8,1"; done; } >"$work/hostile/1_${escape}.csv"
    mkdir -p "$work/nothing"
    sed 's/,1\.8,/,,/' "$work/hostile/1_${escape}.csv" >"$work/nothing/1.csv"
    { ends 1 "$hexid" check "$work/hostile" --json "$work/f.json" -o "$work/f.html" && ends 2 "$hexid" check "$work/empty" && ends 2 "$hexid" check "$work/void" && ends 2 "$hexid" check "$work/nothing" &&
        ends 3 "$hexid" check "$work/void.lcm" && ends 3 "$hexid" check "$work/none.lcm" && ends 3 "$hexid" check README.md && ends 2 "$hexid" check &&
        ends 3 "$hexid" check "$work/run.lcm" --json /nowhere/a.json; } >"$work/said" 2>&1 || { cat -v "$work/said"; return 1; }
    cat -v "$work/said"
    fact "$work/f.json" 't["not_a_number"] == 0 and t["channels"]["length"]["there"] == [2]' && ! LC_ALL=C grep -q $'[\001-\010\013-\037\177\233]' "$work/said" &&
        ! LC_ALL=C grep -q $'[\001-\010\013-\037\177]' "$work/f.html"
}
claim "empty files, no numbers, no logs and names that a terminal would obey do no harm" hostile
