#!/bin/bash
# hexid tune: gains of a machine that has another machine's, from its configuration alone; doctor, run and a fault name them, too.
# tests/test_loop_tune.c measures the margins, tests/long/tune_machines.sh draws twenty machines.
. tests/scenarios/lib

# A platform of 4 t in the geometry of a flight simulator with the default's controller.
heavy=(-c config/simulator.yaml --set payload.mass_kg=4000 --set payload.inertia_xx_kg_m2=7000 --set payload.inertia_yy_kg_m2=9000
    --set payload.inertia_zz_kg_m2=8000 --set payload.inertia_xz_kg_m2=300 --set control.kp=40 --set control.ki=20 --set control.kff=2
    --set control.kpf=2e-5)
says() { for words in "$@"; do grep -qE -- "$words" "$work/out" || { echo "missing: $words"; cat "$work/out"; return 1; }; done; }
lacks() { ! grep -E -- "$1" "$work/out"; }
value() { "$python" -c 'import json, sys; print(eval(sys.argv[2], {"r": json.load(open(sys.argv[1])), "abs": abs}))' "$@"; }
holds() { [ "$(value "$@")" = True ] || { echo "$2: not so"; cat "$1"; return 1; }; }

# Margins are missed with legs near their ends only, so that the run is not refused.
fault() {
    "$hexid" run --fast --set sim.engine=closed_form --set lcm.url= --set control.kp=100 --set control.kpf=2e-6 --set limits.following_m=3e-4 \
        >"$work/out" 2>&1
    says 'warning: gains: ' 'FAULT following_error' '; or the gains, whose margins are missed' 'to do: look at valve.*; the gains: set control.kpf? to [0-9.e-]+ \(now [0-9.e-]+\)'
}
if [ -n "${MORE_CASES:-}" ]; then # make test-long
    claim "a fault that bad gains may set off names them behind its other causes" fault
    exit
fi

tuned() {
    ends 0 "$hexid" tune "${heavy[@]}" -o "$work/tuned.yaml" --json "$work/tune.json" >"$work/out" && cp "$work/out" "$work/printed" &&
        says '^control:' '  kpf: 2.*was 2e-05' 'unstable, and `hexid run` refuses it' 'written +.*tuned.yaml'
}
claim "a platform of 4 t with the default gains gets its own" tuned
wanted='r["schema"] == "hexid.tune/1" and r["reached"] and not r["before"]["stable"] and len(r["after"]["modes"]) == 6'
wanted+=' and r["after"]["gain_margin_db"]["value"] >= 6 and r["after"]["phase_margin_deg"]["value"] >= 45'
wanted+=' and r["after"]["slowest_damping"]["value"] >= 0.3 and r["after"]["control"]["kpf"] < 3e-6'
claim "its JSON has the margins before and after" holds "$work/tune.json" "$wanted"

engages() {
    ends 0 "$hexid" run --fast -c "$work/tuned.yaml" --set sim.engine=closed_form --set lcm.url= >"$work/out" 2>&1 &&
        says 'test 6/6 psi' 'verdict +pass' && lacks 'warning|FAULT'
}
claim "with them it engages, passes its tests, and nothing is warned of" engages

section() {
    sed -n 's/^  kp: *\([^ ]*\).*/\1/p' "$work/printed" >"$work/kp"
    [ "$(cat "$work/kp")" = "$(value "$work/tune.json" 'format(r["after"]["control"]["kp"], "g")')" ]
}
claim "the section that is printed has the gains of the JSON" section

refused() {
    refuses 2 'phi control.kpf (now'$'\n''hexid'$'\n''tune control.kp' "$hexid" run --fast "${heavy[@]}" --set lcm.url=
}
claim "hexid run refuses the default gains and names those of tune" refused

doctor() {
    "$hexid" doctor "${heavy[@]}" --latency 0 >"$work/out" 2>&1
    says 'FAIL +loop' 'WARN +gains' 'do: set control.kpf to [0-9.e-]+ \(now 2e-05\), control.kp to [0-9]+ \(now 40\)'
}
claim "so does hexid doctor" doctor

short() {
    ends 1 "$hexid" tune --set hydraulics.valve_frequency_hz=20 -o "$work/short.yaml" >"$work/out" &&
        says "not reached: damping of the slowest mode.* of 0.3.*limited by the valves' lag" '^control:' && [ -s "$work/short.yaml" ]
}
claim "what is not reached is said, with the part that limits it, and the status is 1" short

plain() {
    (cd "$work" && mkdir plain && cd plain && "$hexid" tune >"$work/out" && [ -z "$(ls -A)" ]) &&
        says '^  gain margin, dB ' '^control:' '  kpf: 6.2e-06.*was 2e-05' && lacks '^written'
}
claim "without -o and --json it prints its result and writes nothing" plain
claim "a load that the supply does not hold gets no gains" refuses 2 "supply does not hold" "$hexid" tune --set payload.mass_kg=90000
claim "an axis has no gains" refuses 2 "mechanism: axis" "$hexid" tune -c config/axis.yaml
claim "the configuration that is read is not overwritten" refuses 2 "name another file" "$hexid" tune -c "$work/tuned.yaml" -o "$work/tuned.yaml"
claim "an unknown machine is refused" refuses 2 "no such back-end" "$hexid" tune --hal nowhere:
