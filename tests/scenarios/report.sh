#!/bin/bash
# hexid report makes one page of hexid identify's results, for one log or several side by side; it shows the same numbers, and refuses
# whatever identify refuses, with nothing left behind.
. tests/scenarios/lib
skip_under tsan "hexid report" "one thread"

dry="--set effects.cylinder_coulomb_friction.force_extend_n=100 --set effects.cylinder_coulomb_friction.force_retract_n=100"
sines=(--set tests.duration_s=2)
multisine=(--set tests.multisine=true --set tests.frequency_hz=1.1,1.7,2.3,3.1,3.7,4.3 --set tests.duration_s=6)
quick "${sines[@]}" --log "$work/a.lcm" >/dev/null 2>&1
quick "${sines[@]}" --seed 2 $dry --log "$work/b.lcm" >/dev/null 2>&1
quick "${multisine[@]}" --log "$work/m.lcm" >/dev/null 2>&1
quick --set tests.duration_s=0.5 --tests x --log "$work/one.lcm" >/dev/null 2>&1
for log in a b m; do "$hexid" identify "$work/$log.lcm" --json "$work/$log.json" >/dev/null 2>&1; done

page="$work/page.html"
report() { "$hexid" report "$@" -o "$page"; }
# shows LOG ...: the page of these logs has every section and the numbers of their JSON.
shows() { ends 0 report "${@/%/.lcm}" && "$python" tests/scenarios/report_page.py "$page" "${@/%/.json}"; }
has() { for words in "$@"; do grep -qF -- "$words" "$page" || { echo "missing: $words"; return 1; }; done; }

# Three minutes and half a second: the remainder is too short for any result.
if [ -n "${MORE_CASES:-}" ]; then # make test-long
    "$python" - "$work/rich.csv" <<'END'
import math, sys
own = ("x_m", 3), ("y_m", 3.5), ("z_m", 2.5), ("phi_rad", 4), ("theta_rad", 4.5), ("psi_rad", 5)
with open(sys.argv[1], "w") as f:
    print("t_s", *(name for name, _ in own), sep=",", file=f)
    for i in range(801): print(0.0025 * i, *(f"{0.003 * math.sin(2 * math.pi * hz * 0.0025 * i):.9f}" for _, hz in own), sep=",", file=f)
END
    minutes() {
        quick --trajectory "$work/rich.csv" --repeat 90 --set tests.settle_s=0.2 --log "$work/minutes.lcm" >/dev/null && ends 0 report "$work/minutes.lcm" &&
            has "The motion is long: the numbers are of all of it." && rm "$work/minutes.lcm"
    }
    claim "a motion of minutes: the page says which part of it the pictures show" minutes
    exit
fi

one_log() { shows "$work/a" && has "The run passed its checks" "method A" "no date: of a run in virtual time" "sinusoids of x y z phi theta psi at 4 Hz"; }
claim "a page of one log has every section, and the numbers of identify --json" one_log
any_motion() {
    shows "$work/m" && has "multisine" "this motion is none for them" "Farthest from the reference" && ! grep -qE 'method A</th>|<h3>Method A' "$page"
}
claim "of any motion method C alone is shown, and methods A and B are not missed" any_motion
side_by_side() {
    shows "$work/a" "$work/b" "$work/m" && has "log 3" "Log 3: All entries of the matrix" "3 of 3 runs passed" "σ from log 1" &&
        "$python" - "$page" "$work/a.json" "$work/b.json" <<'END'
import json, re, sys
page, a, b = open(sys.argv[1]).read(), *(json.load(open(name))["method_a"] for name in sys.argv[2:])
apart = abs(a["Mt"][4][0] - b["Mt"][4][0]) / (a["std"][4][0] ** 2 + b["std"][4][0] ** 2) ** 0.5
row = re.search(r"<tr><td>Mt51.*?</tr>", page, re.S).group()
assert f"{apart:.1f} σ from log 1" in row and apart > 3, (apart, row)
END
}
claim "three logs stand side by side, with the difference over the combined deviation" side_by_side
# A coupling and a product of inertia configured as nearly zero.
near_zero() {
    small=(--set payload.center_height_m=-0.0017 --set payload.inertia_xz_kg_m2=0.01)
    quick "${sines[@]}" "${small[@]}" --log "$work/small.lcm" >/dev/null && ends 0 report "$work/small.lcm" &&
        "$hexid" identify "$work/small.lcm" --json "$work/small.json" >"$work/small.txt" &&
        "$python" - "$page" "$work/small.json" "$work/small.txt" <<'END'
import json, re, sys
page, found, text = open(sys.argv[1]).read(), json.load(open(sys.argv[2])), open(sys.argv[3]).read()
mt, nominal = found["method_c"]["Mt"], found["nominal"]["Mt"]
own = 100 * (mt[0][4] / nominal[0][4] - 1)
pct = 100 * (mt[0][4] - nominal[0][4]) / (nominal[0][0] * nominal[4][4]) ** 0.5
printed = float(re.search(r"^Mt15 +kg m +\S+ +\S+ +(\S+)", text, re.M).group(1))
cells = [float(x) for x in re.findall(r"([-+][\d.]+) %", re.search(r"<tr><td>Mt15.*?</tr>", page, re.S).group())]
product = [float(x) for x in re.findall(r"([-+][\d.]+) %", re.search(r"<tr><td>inertia xz.*?</tr>", page, re.S).group())]
print(own, pct, printed, cells, product)
assert abs(own) > 20 * abs(pct) and abs(printed - pct) < 0.01 and abs(cells[0] - pct) < 0.01 and abs(product[0]) < 10
END
}
claim "a difference from nearly nothing is in % of sqrt(Mii Mjj), not of nothing" near_zero
claim "a browser draws it, wide and narrow, in light and in dark, without a sideways scroll" "$python" tests/scenarios/report_view.py "$page" "$work"
friction() { # the drawn step is the friction of the simulation: within its interval around 100 N
    ends 0 report "$work/b.lcm" && "$python" - "$page" <<'END'
import re, sys
legs = re.findall(r'<figcaption>Leg \d: viscous .*? dry ([-\d.]+) ± ([\d.]+) N extending, ([-\d.]+) ± ([\d.]+) N retracting', open(sys.argv[1]).read())
assert len(legs) == 6, legs
hits = sum(abs(float(leg[i]) - 100.0) < float(leg[i + 1]) for leg in legs for i in (0, 2))
assert hits >= 9, legs  # of 12; fewer than 9 have a probability below 1 in 2000 if each interval holds with 95 %
END
}
claim "the friction drawn for each leg is what the machine was given" friction
# Amplitudes stand beside the recorded reference, as the verdict judges them, whatever the configuration states.
recorded_amplitude() {
    report "$work/a.lcm" --set tests.amplitude_m=0.001 --set tests.amplitude_rad=0.001 >/dev/null
    [ "$(grep -oE 'of (4\.00|3\.99|6\.00|5\.99)[0-9] m' "$page" | wc -l)" = 6 ]
}
same_machine() { report "$work/a.lcm" --set payload.mass_kg=260 >/dev/null && has "payload configured with 260 kg" "mass_kg: 260"; }
claim "an amplitude is shown against that of the recorded reference" recorded_amplitude
claim "--set changes the model that is shown" same_machine

quick "${sines[@]}" --tests x --log "$work/x.lcm" >/dev/null 2>&1
"$hexid" identify "$work/x.lcm" --json "$work/x.json" >/dev/null 2>&1
open_entries() {
    ends 1 report "$work/x.lcm" && has "– : not determined by this motion" "they need complete tests of all six axes" &&
        grep -q '<td>mx <span class="small">kg</span></td><td class="n">272[.0-9]*</td><td class="n[ a-z]*">2[678][0-9]' "$page" &&
        grep -q '<td>Izz <span class="small">kg m²</span></td><td class="n">[.0-9]*</td><td class="n">–</td>' "$page"
}
claim "of a test of x alone mx is shown, and Izz is a dash that is explained" open_entries
short() {
    ends 1 report "$work/one.lcm" >"$work/text" && has "Methods A and B: not evaluated" "Method C: not evaluated: " "too short" "<b>not_evaluated</b>" &&
        grep -q 'not_evaluated' "$work/text"
}
claim "what was not evaluated is said, with the reason, and the status is identify's" short
damaged() {
    head -c 3000000 "$work/a.lcm" >"$work/cut.lcm"
    ends 1 report "$work/cut.lcm" 2>"$work/error" && grep -q 'cut.lcm is cut off' "$work/error" && has "cut off or damaged: read up to byte"
}
claim "a log that is cut off is shown as far as it goes, and says so" damaged
"$python" - "$work/m.lcm" "$work/still.lcm" <<'END'
import struct, sys # the events before the motion, and half a second of it
data, place, seen = open(sys.argv[1], "rb").read(), 0, 0
while place < len(data) and seen < 1600:
    channel, size = struct.unpack(">ii", data[place + 20:place + 28])
    place, seen = place + 28 + channel + size, seen + 1
open(sys.argv[2], "wb").write(data[:place])
END
nothing() {
    rm -f "$page"
    refuses 2 "still.lcm: nothing to identify" "$hexid" identify "$work/still.lcm" && refuses 2 "still.lcm: nothing to identify" report "$work/a.lcm" "$work/still.lcm" &&
        [ ! -e "$page" ]
}
claim "a log from which nothing comes is refused as by identify, and no page is left" nothing
gone() { rm -f "$page"; refuses "$1" "$2" report "${@:3}" && [ ! -e "$page" ]; }
claim "a log that is not there: refused, no page" gone 3 "none.lcm" "$work/a.lcm" "$work/none.lcm"
claim "a file that is no log: refused, no page" gone 3 "Makefile" Makefile
claim "seven logs: refused, with the number" gone 2 "takes 6" "$work/a.lcm"{,,,,,,}
claim "no page named: refused" refuses 2 "-o" "$hexid" report "$work/a.lcm"
claim "a page in a log's place: refused" refuses 2 "is one of the logs" "$hexid" report "$work/a.lcm" -o "$work/a.lcm"
claim "a page where none can be written: refused before the log is read" refuses 3 "/nowhere/page.html" "$hexid" report "$work/a.lcm" -o /nowhere/page.html

escape=$'\033[2J\a'
hostile() {
    local name="$work/<script>alert(1)<b>\"'&${escape}.lcm"
    cp "$work/one.lcm" "$name"
    ends 1 "$hexid" report "$name" -o "$page" --set 'lcm.url="<script>x</script>"' >"$work/said" 2>&1
    cat -v "$work/said"
    ! LC_ALL=C grep -q $'[\001-\010\013-\037\177]' "$work/said" "$page" && ! grep -qE '<script|<b>"' "$page" && has '&lt;script&gt;alert(1)&lt;b&gt;&quot;&#39;&amp;'
}
claim "names and settings that a browser or a terminal would obey do no harm" hostile
no_gnuplot() { PATH=/nowhere report "$work/a.lcm" >/dev/null 2>"$work/error"; }
without_gnuplot() { ends 3 no_gnuplot && grep -q gnuplot-nox "$work/error" && has 'picture not drawn' 'All entries of the matrix'; }
claim "without gnuplot the page is written without pictures, and the status says so" without_gnuplot
standard_output() { "$hexid" report "$work/a.lcm" -o - 2>/dev/null | tail -n 1 | grep -qx '</html>'; }
claim "-o - writes the page to standard output and nothing else" standard_output
