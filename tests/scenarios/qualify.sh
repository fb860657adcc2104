#!/bin/bash
# hexid run --qualify drives ten minutes of motion, and hexid qualify measures its log: describing functions agree with single sines,
# hidden effects change the expected quantities, and limits, baseline and page work. tests/test_quality.c measures recordings with known
# results, and reads text and page.
. tests/scenarios/lib

exact=(--set sim.engine=closed_form --set lcm.url= --set sensors.enabled=false)
value() { "$python" -c 'import json, sys; print(eval(sys.argv[2], {"r": json.load(open(sys.argv[1])), "o": json.load(open(sys.argv[-1])), "axis": lambda r, n: next(a for a in r["axes"] if a["axis"] == n)}))' "$@"; }
holds() { [ "$(value "$@")" = True ] || { echo "$2: not so"; return 1; }; }
says() { for words in "$@"; do grep -qE -- "$words" "$work/out" || { echo "missing: $words"; cat "$work/out"; return 1; }; done; }
qualified() { # NAME OPTION...: drives the motion and measures its log
    local name=$1
    shift
    ends 0 "$hexid" run --fast "${exact[@]}" --qualify "$@" --log "$work/$name.lcm" >"$work/run.out" 2>&1 || { cat "$work/run.out"; return 1; }
    ends 0 "$hexid" qualify "$work/$name.lcm" --json "$work/$name.json" >"$work/out"
}

# A machine that no test may drive is not driven by this motion either.
claim "a platform that hangs is refused" refuses 2 "not run geometry.height_m hangs" "$hexid" run --fast "${exact[@]}" --qualify --set geometry.height_m=-1.64
claim "a machine that is blind for too long is refused" \
    refuses 2 "not run limits.blind_time_s" "$hexid" run --fast "${exact[@]}" --qualify --set limits.blind_time_s=0.01
claim "a ramp that is a blow is refused" refuses 2 "not run tests.ramp_s" "$hexid" run --fast "${exact[@]}" --qualify --set tests.ramp_s=0.001
quick --tests x --log "$work/sines.lcm" >/dev/null 2>&1
claim "a log of another motion is refused" refuses 2 "its motion is none of run --qualify" "$hexid" qualify "$work/sines.lcm"
short() {
    refuses 2 "samples of the motion are missing" "$hexid" qualify "$work/sines.lcm" -c config/tian2015.yaml -o "$work/none.html" &&
        [ ! -e "$work/none.html" ]
}
claim "and so is a log that has too little of the motion, without a page" short
claim "a machine of one axis is refused" refuses 2 "mechanism" "$hexid" run --fast -c config/axis.yaml --qualify
claim "another motion beside it is refused" refuses 2 "--qualify --survey" "$hexid" run --fast --qualify --survey
[ -n "${MORE_CASES:-}" ] || exit 0 # ten minutes of motion: make test-long

claim "a run of it is an ordinary run, with a verdict of its own and method C's result" \
    eval 'qualified a && grep -q "verdict  *pass" "$work/run.out" && grep -qE "^loop +28[0-9]{4} cycles of 2 ms, 0 overruns" "$work/run.out"'
claim "it says measured as, and evaluates nothing without a limit" says '^measured as' '^verdict   not_evaluated'
claim "describing functions are those of single sines, within 2 % and 2 degrees" \
    "$python" tests/scenarios/qualify.py "$hexid" "$work/a.json" "${exact[@]}"

hidden() {
    # a hysteresis of 0.02 in the valve moves a leg by 0.02 / kp = 0.5 mm, and the platform by that divided by 0.42, the leg's change per
    # metre of x
    qualified hidden --set effects.valve_hysteresis.width=0.02 --set effects.command_delay.delay_s=0.005 &&
        holds "$work/hidden.json" '0.8e-3 < axis(r, "x")["hysteresis"] - axis(o, "x")["hysteresis"] < 1.4e-3' "$work/a.json" &&
        holds "$work/hidden.json" '0.003 < axis(r, "z")["dead_s"] - axis(o, "z")["dead_s"] < 0.006' "$work/a.json"
}
claim "a valve's hysteresis and a delay that are hidden in the machine widen the loop and add to the dead time" hidden

against() {
    ends 1 "$hexid" qualify "$work/hidden.lcm" --baseline "$work/a.json" --set qualify.repeat_mps2=0.05 --json "$work/b.json" -o "$work/page.html" \
        >"$work/out" && says '^fail +change from the baseline' '^verdict   fail' && holds "$work/b.json" 'r["baseline"]["of_noise"] > 3' "$work/a.json" &&
        grep -q 'Measured as outside the operator' "$work/page.html" && grep -q 'Against the baseline' "$work/page.html"
}
claim "against the baseline it has changed, and a limit on that fails" against
itself() {
    ends 0 "$hexid" qualify "$work/a.lcm" --baseline "$work/a.json" --set qualify.repeat_mps2=0.05 --set qualify.phase_deg=10 >"$work/out" &&
        says '^pass +change from the baseline' '^pass +phase' '^not_evaluated cross-talk' '^verdict   pass'
}
claim "against itself nothing has; limits that hold pass, what has none is not evaluated" itself
holes() { # a tone without a number is neither drawn nor a change that is small enough
    "$python" -c 'import json, sys; r = json.load(open(sys.argv[1])); r["axes"][2]["tones"][3]["gain"] = [None] * 6; json.dump(r, open(sys.argv[2], "w"))' \
        "$work/a.json" "$work/holes.json"
    ends 1 "$hexid" qualify "$work/a.lcm" --baseline "$work/holes.json" --set qualify.repeat_mps2=0.05 -o "$work/holes.html" >"$work/out" &&
        says '^not_evaluated change from the baseline.*some are not measured' '^verdict   not_evaluated'
}
claim "against a baseline with a hole nothing passes, and the page is drawn" holes
view() { [ -n "$(command -v chromium)" ] || { echo "no chromium"; return 0; }; "$python" tests/scenarios/report_view.py "$work/page.html" "$work"; }
claim "a browser draws the page, wide and narrow, light and dark" view

claim "a baseline that is none is refused" refuses 2 "not a result of" "$hexid" qualify "$work/a.lcm" --baseline tests/scenarios/qualify.py
claim "--json does not overwrite the baseline" \
    refuses 2 "--json baseline another" "$hexid" qualify "$work/a.lcm" --baseline "$work/a.json" --json "$work/a.json"
cut() { head -c 60000000 "$work/a.lcm" >"$work/cut.lcm" && "$hexid" qualify "$work/cut.lcm" >"$work/out" 2>&1; [ $? = 2 ] && says 'samples of the motion are missing'; }
claim "a log that ends early is refused" cut
