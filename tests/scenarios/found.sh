#!/bin/bash
# hexid run drives with the file that hexid identify --model writes: a machine with a payload that the configuration does not know is
# identified, and then driven again.
. tests/scenarios/lib

quick --print-config >"$work/all.yaml"
edit() { sed -E "$@" "$work/all.yaml"; }
# The machine has 40 % more payload than the configuration says.
edit 's/^  mass_kg: 178.6 /  mass_kg: 250 /; s/(inertia_(xx|yy)_kg_m2): 13.6 /\1: 19 /; s/(inertia_zz_kg_m2): 23.92 /\1: 33.5 /' >"$work/truth.yaml"
grep -q 'mass_kg: 250 ' "$work/truth.yaml" || echo "not ok - the machine's configuration was not made"

key() { sed -nE "s/^ +$2: \[?([-0-9.e+]+).*/\1/p" "$work/$1" | head -n 1; }
near() { awk -v x="$1" -v y="$2" -v t="$3" 'BEGIN { d = x - y; exit !((d < 0 ? -d : d) <= t) }' || { echo "$1 is not $2 within $3"; return 1; }; }
# off FILE: prints the largest relative error of an amplitude in the six tests of a run, in thousandths.
off() { awk '/ test [1-6]\/[1-6] / { e = $4 / $6 - 1; e = e < 0 ? -e : e; m = e > m ? e : m; n++ } END { if (n == 6) print int(1000 * m); else exit 1 }' "$work/$1"; }

drive() { quick --hal "sim:$work/truth.yaml" --set control.law=model --set tests.duration_s=2 "${@:2}" >"$work/$1" 2>&1 || [ $? = 1 ]; }
quick --hal "sim:$work/truth.yaml" --set tests.duration_s=2 --log "$work/a.lcm" >"$work/said" 2>&1
written() {
    "$hexid" identify "$work/a.lcm" --model "$work/machine.yaml" >"$work/said" && grep -q 'keys found, each with its interval' "$work/said" &&
        near "$(key machine.yaml mass_kg)" 250 4 && near "$(key machine.yaml inertia_zz_kg_m2)" 33.5 1.5 &&
        grep -q 'mass_kg: .*# +- .* (95 %); was 178.6' "$work/machine.yaml"
}
claim "identify --model writes the payload that the machine has, with its interval" written
shrinks() {
    drive before && drive after -c "$work/machine.yaml" && grep -q 'test 6/6' "$work/after" &&
        before=$(off before) && after=$(off after) && echo "amplitudes off by $before, then $after thousandths" && [ "$before" -ge 40 ] && [ $((8 * after)) -le "$before" ]
}
claim "driven with it, the error of the amplitudes is an eighth at most" shrinks
bare() { sed 's/#.*//; s/ *$//; /^$/d' "$@"; }
again() { "$hexid" run -c "$work/machine.yaml" --print-config | bare >"$work/one" && bare "$work/machine.yaml" | diff "$work/one" -; }
claim "what it writes is a configuration, key by key" again

quick --set tests.duration_s=2 --set 'effects.pressure_sensor_scale.p1=[1,1,1.06,1,1,1]' --log "$work/f.lcm" >"$work/said" 2>&1
failed() {
    ends 1 "$hexid" identify "$work/f.lcm" --model "$work/none.yaml" >"$work/said" || { cat "$work/said"; return 1; }
    grep -q 'not written: the verdict is' "$work/said" && [ ! -e "$work/none.yaml" ]
}
claim "without a verdict of pass nothing is written, and it says so" failed
claim "-o and --model together are refused" refuses 2 "-o --model one" "$hexid" identify "$work/a.lcm" -o "$work/x" --model "$work/y"
claim "--model over the log is refused" refuses 2 "--model logs" "$hexid" identify "$work/a.lcm" --model "$work/a.lcm"
claim "a simulated machine of another cycle is refused" refuses 2 "loop.period_s" "${quick[@]}" --hal "sim:$work/truth.yaml" --set loop.period_s=0.001
claim "so is one whose file is not there" refuses 2 "none.yaml" "${quick[@]}" --hal "sim:$work/none.yaml"
