#!/bin/bash
# Messages of hexid identify for bad recordings: the reason and the remedy.
. tests/scenarios/lib
skip_under tsan "bad data" "one thread"

identify() { "$hexid" identify "$@" >"$work/out" 2>&1; }
says() { for words in "$@"; do grep -qE -- "$words" "$work/out" || { echo "missing: $words"; cat "$work/out"; return 1; }; done; }
long=(--set tests.duration_s=2)

few() { quick --log "$work/few.lcm" >/dev/null; identify "$work/few.lcm"; says 'method C  not evaluated: test x: 0.998 s evaluated, too short: at least 6 cycles'; }
claim "too few cycles: method C says so, and how many it takes" few

# Only x is tested: entries that need rotations are null, and so are the legs' dry frictions, which one test cannot separate. The payload is
# one body, so its mass is the same along x, y and z.
one_axis() {
    quick --tests x "${long[@]}" --log "$work/x.lcm" >/dev/null
    ends 1 identify "$work/x.lcm" --json "$work/x.json"
    says 'data +determine [0-9]+ of 21 entries' 'not determined: .*Mt44 .*Mt66' 'takes motion.* of phi theta psi' '^dry, extending +-' '^Izz .*not determined' &&
        "$python" -c 'import json, sys
c = json.load(open(sys.argv[1]))["method_c"]
assert c["std"][5][5] is None and all(c["Mt"][i][i] is None for i in range(3, 6)) and None not in c["Mt"][0]
assert c["dry_friction_n"]["extend"] == [None] * 6 and c["payload"]["value"]["inertia_zz_kg_m2"] is None, c' "$work/x.json"
}
claim "axes that no test moves: their entries are null and the motion that they need is named" one_axis
whole() { quick "${long[@]}" --log "$work/six.lcm" >/dev/null && identify "$work/six.lcm" && says 'data +determine 21 of 21 entries' && ! grep -qE 'not determined( by|: Mt)' "$work/out"; }
claim "six axes: all 21 entries are determined" whole
brief() {
    quick "${long[@]}" --log "$work/brief.lcm" | sed '1,/^  settled$/d' | sed '1,/^  settled$/d' >"$work/out" &&
        says '^ +mx +my +mz +Ixx +Iyy +Izz$' '^method C .* 5[0-9]\.[0-9]+$' '^error .* %$' '^\+- 95 % .* %$' '^verdict   pass$' &&
        [ "$(grep -c . "$work/out")" -le 10 ] && [ "$(tail -n 1 "$work/out")" = "whole     hexid identify $work/brief.lcm" ]
}
claim "a run ends with ten lines: method C's diagonal, loop, verdict, log, and the command that shows the whole" brief
verbose() {
    local table='/^data      determine/,/^loop /p'
    quick "${long[@]}" --verbose --log "$work/verbose.lcm" | sed -n "$table" >"$work/run" && identify "$work/verbose.lcm" && sed -n "$table" "$work/out" >"$work/same" &&
        [ "$(wc -l <"$work/run")" -gt 40 ] && cmp "$work/run" "$work/same"
}
claim "with --verbose it prints the table of hexid identify" verbose

# A motion of z alone: all six legs move as one. Noise of the other axes' accelerations must not pass for their motion, which would make
# their masses too small.
"$python" - "$work/z.csv" <<'END'
import math, sys
with open(sys.argv[1], "w") as f:
    print("t_s,z_m", file=f)
    for i in range(201): print(f"{0.01 * i:.2f},{0.004 * math.sin(0.08 * math.pi * i):.9f}", file=f)
END
rank() {
    quick --trajectory "$work/z.csv" --repeat 3 --log "$work/z.lcm" >/dev/null
    identify "$work/z.lcm"
    says 'not determined: .*Mt44' || { cat "$work/out"; return 1; }
}
claim "a motion of one axis, legs in step: rank is lacking, and what lacks it is no number" rank

# altered NAME CODE: the six tests with every row of every file changed by Python, where x contains the columns' values by name.
altered() {
    rm -rf "$work/csv" && "$hexid" export "$work/six.lcm" -o "$work/csv" >/dev/null && "$python" - "$work/csv" "$2" <<'END' &&
import csv, glob, sys
for name in glob.glob(sys.argv[1] + "/*.csv"):
    head = [line for line in open(name) if line.startswith("#")]
    rows = list(csv.DictReader(line for line in open(name) if not line.startswith("#")))
    for n, x in enumerate(rows): exec(sys.argv[2])
    with open(name, "w", newline="") as f:
        f.writelines(head)
        out = csv.DictWriter(f, rows[0].keys(), lineterminator="\n")
        out.writeheader()
        out.writerows(rows)
END
        "$hexid" import "$work/csv" -o "$work/$1.lcm" >"$work/import" 2>&1 || { cat "$work/import"; return 1; }
    identify "$work/$1.lcm"
}
saturated() { altered saturated 'x["u3"] = max(-0.05, min(0.05, float(x["u3"])))' && identify "$work/saturated.lcm" --set control.output_limit=0.05; }
claim "a command that is at its limit: method C needs lengths and pressures alone, and has its matrix" eval \
    'saturated; says "^data +determine 21 of 21 entries" "^verdict +pass"'
claim "a pressure sensor at the end of its range: refused with sensor, leg and share" eval \
    'altered clipped "x[\"p2_4_pa\"] = min(6.3e6, float(x[\"p2_4_pa\"]))"; says "not evaluated: test [a-z]+: p2 of leg 4 is clipped in [0-9]+ % of the samples"'
claim "every twentieth sample flagged: the verdict fails, with share and limit" eval \
    'altered flagged "x[\"flags\"] = int(n % 20 == 0)"; says "verdict +fail" "test x: [0-9.]+ % of the samples excluded, limit 1 %"'
claim "most samples flagged: method C refuses them" eval \
    'altered useless "x[\"flags\"] = int(n % 5 != 0)"; says "not evaluated: test x: more than half of its samples are flagged"'
