#!/bin/bash
# The loop's wake-up beside cyclictest's on the same machine in the same minutes, and a real 2 ms with --rt require.
. tests/scenarios/lib
chrt -f 80 true 2>/dev/null || { echo "ok - latency # SKIP this user has no SCHED_FIFO: run as root"; exit; }

quiet=(--set motion.engage_s=3 --set motion.park_s=3 --set motion.hold_s=0 --set tests.settle_s=1 --set tests.ramp_s=0.2
    --set tests.ramp_out_s=0.2 --set tests.duration_s=0.5 --set lcm.url=)
beside() { cyclictest --quiet --mlockall --policy=fifo --priority=80 --interval=2000 --threads=1 --duration=60 --histogram=50000 >"$work/cyclic" & }
run() { "$hexid" run --hal sim: --rt require "${quiet[@]}" --json "$work/loop.json" >"$work/run"; }
beside
cyclic=$!
run
status=$?
kill -INT $cyclic && wait $cyclic
# compare loop JSON
compare() {
    "$python" - "$work/cyclic" "$@" <<'END'
import json, sys
count = {}
for line in open(sys.argv[1]):
    if line[:1].isdigit():
        us, n = map(int, line.split()[:2])
        count[us] = n
total, seen = sum(count.values()), 0
for bare_us, n in sorted(count.items()):
    seen += n
    if seen > 0.99 * total:
        break
measured = json.load(open(sys.argv[3]))
own_us = measured["loop"]["wake_us"]["p99"]
print(f"wake-up p99: {sys.argv[2]} {own_us:.0f} us, cyclictest {bare_us} us")
sys.exit(own_us > 3 * bare_us + 50)
END
}
claim "the loop's wake-up p99 is within three times cyclictest's and 50 us" compare loop "$work/loop.json"
sed 's/^/# /' "$work/claim.out"
kept() { cat "$work/run"; echo "exit status $status"; [ $status -eq 0 ]; }
text="a real 2 ms is kept with --rt require, on a machine that does not stand still for 5 ms"
still_us=$(sed -n 's/^# Max Latencies: *0*//p' "$work/cyclic")
if ((status && still_us >= 5000)); then
    echo "ok - $text # SKIP cyclictest beside it was held up for $still_us us"
else
    claim "$text" kept
fi

# Judges by the ratio alone: within 1.5, or within cyclictest's ratio to itself in the same turns.
agrees() {
    HEXID=$hexid "$python" - <<'END'
import sys
sys.dont_write_bytecode = True
sys.path.insert(0, "tests/rt")
import bench_rt, wake
turns = bench_rt.Turns(.002, 6)
for _ in range(5): turns.turn("doctor", wake.doctor)
ratio, spread = turns.median_ratio("doctor", "p99"), turns.spread("p99")
print("doctor --latency over cyclictest in turns, p99: %.2f; cyclictest over itself %.2f" % (ratio, spread))
sys.exit(not 1 / max(1.5, spread) <= ratio <= max(1.5, spread))
END
}
claim "what doctor --latency says agrees with cyclictest in the same minute" agrees
sed 's/^/# /' "$work/claim.out"
