#!/bin/bash
# hexid identify combines several logs of one machine: repeats are averaged, disagreement is reported, another machine is refused.
. tests/scenarios/lib
skip_under tsan "several logs" "one thread"

identify() { "$hexid" identify "$@" >"$work/out" 2>&1; }
says() { for words in "$@"; do grep -qE -- "$words" "$work/out" || { echo "missing: $words"; cat "$work/out"; return 1; }; done; }
quick_settings+=(--set tests.duration_s=4) # sixteen cycles, from whose differences the noise is known to a fifth
quick=("$hexid" run --hal sim: --fast "${quick_settings[@]}")
for seed in 1 2 3; do quick --seed $seed --log "$work/$seed.lcm" >/dev/null; done
repeats=("$work"/{1,2,3}.lcm)

agree() { ends 0 identify "${repeats[@]}" --json "$work/all.json" && says 'log 3 .*3.lcm: pass' '^Mt11 .*kg' '^dry leg 6 retracting' 'the logs agree' 'verdict +pass'; }
claim "three repeats: each beside the others and all of them together; they agree" agree
combined() {
    "$hexid" identify "$work/2.lcm" --json "$work/2.json" >/dev/null && "$python" - "$work" <<'END'
import json, sys
all, one = (json.load(open(f"{sys.argv[1]}/{name}.json")) for name in ("all", "2"))
second = dict(all["logs"][1])
assert second.pop("log").endswith("2.lcm") and second == one, "a log's own result is not that of the log alone"
def noise(c, i, j): return c["variance_shares"]["noise"][i][j] * c["std"][i][j] ** 2 # the rest is in all logs
for i in range(6): assert noise(all["combined"]["method_c"], i, i) < 0.6 * min(noise(log["method_c"], i, i) for log in all["logs"]), i
assert all["agreement"]["agree"] and all["agreement"]["degrees"] == 78 and all["agreement"]["probability"] > 1e-3
assert all["agreement"]["apart"] == [] and all["verdict"]["status"] == "pass"
END
}
claim "in the JSON each log is what it is alone, and all together are surer than any" combined

quick --seed 4 --log "$work/rubs.lcm" --set effects.cylinder_coulomb_friction.force_extend_n=0,0,60,0,0,0 \
    --set effects.cylinder_coulomb_friction.force_retract_n=0,0,60,0,0,0 >/dev/null
disagree() {
    ends 1 identify "${repeats[@]}" "$work/rubs.lcm" --json "$work/rubs.json" && says 'the logs disagree' 'verdict +fail' \
        'dry leg 3 (extending|retracting) of log 4 is \+[0-9.]+ standard deviations from the others' '^dry leg 3 .*\*' &&
        "$python" -c 'import json, sys
agreement = json.load(open(sys.argv[1]))["agreement"]
assert not agreement["agree"] and any(a["log"] == 4 and a["value"].startswith("dry leg 3") for a in agreement["apart"]), agreement' "$work/rubs.json"
}
claim "a leg that rubs in one of them: named, with the log and by how much; exit status 1" disagree

quick --seed 5 --set tests.multisine=true --set tests.frequency_hz=1.1,1.7,2.3,3.1,3.7,4.3 --set tests.duration_s=12 --log "$work/multisine.lcm" >/dev/null
claim "another motion of the same machine is combined, too" ends 0 identify "$work/1.lcm" "$work/multisine.lcm"
for axes in x,y z,phi theta,psi; do quick --tests $axes --log "$work/$axes.lcm" >/dev/null; done
parts() {
    ends 0 identify "$work"/{x\,y,z\,phi,theta\,psi}.lcm --json "$work/parts.json" && says 'verdict +pass' && "$python" -c 'import json, sys
report = json.load(open(sys.argv[1]))
assert all(any(x is None for row in log["method_c"]["Mt"] for x in row) for log in report["logs"])
assert all(x is not None for row in report["combined"]["method_c"]["Mt"] for x in row)' "$work/parts.json"
}
claim "two axes in each of three logs, none with the whole matrix: together they have it" parts

quick --seed 6 --set payload.mass_kg=150 --log "$work/lighter.lcm" >/dev/null
claim "a log of another machine: refused, with both logs, the key, both values and the remedy" \
    refuses 2 "lighter.lcm 1.lcm payload.mass_kg 150 178.6 -c" "$hexid" identify "$work/1.lcm" "$work/lighter.lcm"
says_which() {
    quick --print-config >"$work/rig.yaml"
    identify "$work/1.lcm" "$work/lighter.lcm" -c "$work/rig.yaml"
    says 'the logs disagree' 'Mt11 of log [12] is' # as logs of different machines
}
claim "-c says which configuration both have" says_which
at_pose() {
    ends 0 identify "$work/1.lcm" --pose 0,0,0,0,0,0 --json "$work/here.json" && says '^Mt at 0 0 0 m, 0 0 0 rad' &&
        ends 0 identify "${repeats[@]}" --pose 0.1,0,-0.05,0,0,0.3 --json "$work/there.json" && "$python" -c 'import json, sys
here, there = (json.load(open(f)) for f in sys.argv[1:])
here, there = here["method_c"], there["combined"]["method_c"]
for i in range(6):
    for j in range(6): assert abs(here["at_pose"]["Mt"][i][j] - here["Mt"][i][j]) < 4 * here["std"][i][j], (i, j)
    assert there["at_pose"]["Mt"][i][i] > 0
p, c = there["payload"]["value"], there["at_pose"]
assert c["pose"] == [0.1, 0, -0.05, 0, 0, 0.3]
assert abs(c["Mt"][2][2] - p["mass_kg"]) < 110  # and six legs of some 16 kg along z' "$work/here.json" "$work/there.json"
}
claim "--pose: the matrix there, at neutral that of method C within its deviations" at_pose
claim "--pose beyond the strokes: refused, with leg and stroke" refuses 2 "--pose leg 1 1.431 2.231 strokes" "$hexid" identify "$work/1.lcm" --pose 2,0,0,0,0,0
claim "--pose of five numbers: refused, with an example" refuses 2 "--pose six numbers" "$hexid" identify "$work/1.lcm" --pose 0,0,0,0,0
claim "a log given twice: refused, naming it" refuses 2 "1.lcm twice" "$hexid" identify "$work/1.lcm" "$work/2.lcm" "$work/../${work##*/}/1.lcm"
cp "$work/1.lcm" "$work/copy.lcm"
claim "a copy of a log: refused, naming both" refuses 2 "copy.lcm 1.lcm twice" "$hexid" identify "$work/1.lcm" "$work/copy.lcm"
claim "seventeen logs: refused" refuses 2 "17.lcm one argument too many" "$hexid" identify "$work"/{1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17}.lcm
# A log that lcm-logger recorded beside two runs of the daemon, or that cat has joined.
cat "$work/1.lcm" "$work/2.lcm" >"$work/both.lcm"
cat "$work/1.lcm" "$work/lighter.lcm" >"$work/others.lcm"
two_runs() {
    local of="both.lcm 2 runs --run N 1: 2:"
    refuses 3 "$of" "$hexid" identify "$work/both.lcm" && refuses 3 "$of" "$hexid" check "$work/both.lcm" &&
        refuses 3 "$of" "$hexid" report "$work/both.lcm" -o "$work/never.html" && [ ! -e "$work/never.html" ] &&
        refuses 3 "$of" "$hexid" gap --measured "$work/both.lcm" -c "$work/rig.yaml" -o "$work/never" && [ ! -e "$work/never" ] &&
        for how in "-o $work/never" "--all -o $work/never" "--format mcap -o $work/never"; do
            refuses 3 "$of" "$hexid" export "$work/both.lcm" $how && [ ! -e "$work/never" ] || return 1
        done && refuses 3 "others.lcm different configurations --run" "$hexid" identify "$work/others.lcm"
}
claim "a log of two runs: refused by every subcommand, with the runs and the option that takes one" two_runs
one_of_two() {
    local run
    for run in 1 2; do
        ends 0 identify "$work/both.lcm" --run $run --json "$work/run.json" && ends 0 identify "$work/$run.lcm" --json "$work/alone.json" &&
            cmp "$work/run.json" "$work/alone.json" && "$hexid" export "$work/both.lcm" --run $run --all -o "$work/run$run.csv" &&
            "$hexid" export "$work/$run.lcm" --all -o "$work/alone$run.csv" && cmp "$work/run$run.csv" "$work/alone$run.csv" || return 1
    done
    refuses 2 "--run 3 2 runs" "$hexid" identify "$work/both.lcm" --run 3 && refuses 2 "--run one log" "$hexid" identify "$work/1.lcm" "$work/both.lcm" --run 1
}
claim "--run takes one of them: the same result and the same table as of its own log" one_of_two
claim "one that is not there: I/O error, naming it" refuses 3 "none.lcm" "$hexid" identify "$work/1.lcm" "$work/none.lcm"
