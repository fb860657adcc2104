#!/bin/bash
# `make bench`: what every part of a cycle costs, in time and in instructions, and how the loop compares with the bare machine.
# Prints tables and writes BUILD/bench.csv. It judges nothing: on a shared machine only ratios, medians and instructions mean something.
set -u
build=$1
bench=$build/tests/bench/bench
hexid=$build/hexid
runs=15
export LC_ALL=C
work=$(mktemp -d "$build/bench.XXXXXX")
trap 'rm -rf "$work"' EXIT
csv=$build/bench.csv
echo "name,unit,median,p10,p90,runs,instructions" >"$csv"

# Quantiles of the numbers on standard input: p10 median p90.
quantiles() {
    sort -g | awk 'function at(share) { return v[int(1 + share * (NR - 1) + 0.5)] }
        { v[NR] = $1 }
        END { printf "%s %s %s\n", at(0.1), v[int((NR + 1) / 2)], at(0.9) }'
}

# NAME UNIT SCALE INSTRUCTIONS, runs on standard input.
row() {
    local name=$1 unit=$2 scale=$3 instructions=$4 count p10 median p90
    awk -v s="$scale" '{ printf "%.4g\n", $1 * s }' >"$work/row"
    count=$(wc -l <"$work/row")
    read -r p10 median p90 < <(quantiles <"$work/row")
    printf '%-54s %10s %10s %10s  %-6s %12s\n' "$name" "$median" "$p10" "$p90" "$unit" "$instructions"
    echo "$name,$unit,$median,$p10,$p90,$count,$instructions" >>"$csv"
}
title() { printf '\n%-40s %10s %10s %10s  %-6s %12s\n' "$1" median p10 p90 unit "$2"; }

title "per operation, $runs runs" instructions
for name in $("$bench"); do
    "$bench" "$name" "$runs" >"$work/$name" || continue
    operations=$(awk 'NR == 1 { print $2 }' "$work/$name")
    valgrind --tool=callgrind --toggle-collect='measured_*' --callgrind-out-file=/dev/null "$bench" "$name" 1 >/dev/null 2>"$work/callgrind"
    instructions=$(awk -v n="$operations" '/Collected :/ { printf "%.0f", $NF / n }' "$work/callgrind")
    awk '{ print $1 }' "$work/$name" | row "$name" us 1e-3 "$instructions"
done

title "simulation against real time, 8 steps a cycle of 2 ms" ""
for name in $("$bench" | grep sim_step); do
    awk '{ print 2e6 / (8 * $1) }' "$work/$name" | row "${name/step/real_time_factor}" x 1 ""
done
for name in $("$bench" | grep sim_step_ode); do
    awk '{ print $3 }' "$work/$name" | row "${name/step/over_dWorldStep}" x 1 ""
done

# Six tests; closed form, because ten hours of rigid bodies are not what is measured. The first reading warms the cache.
title "hexid identify LOG (warm cache)" "max RSS"
for seconds in 5 60 600; do
    log=$work/$seconds.lcm
    "$hexid" run --hal sim: --fast --set sim.engine=closed_form --set tests.duration_s=$seconds --set lcm.url= --log "$log" \
        >"$work/run" 2>&1
    [ -s "$log" ] || { tail -n 3 "$work/run"; continue; }
    for _ in 0 1 2 3; do "$bench" use "$hexid" identify "$log" --json "$work/identify.json" 2>/dev/null | tail -n 1; done |
        tail -n 3 >"$work/use"
    awk '{ print $1 }' "$work/use" | row "identify_6_x_${seconds}_s" s 1 "$(awk '$2 > m { m = $2 } END { print m " kB" }' "$work/use")"
    rm -f "$log"
done

# Real time against the bare machine: in turns, so that both see the same minutes.
if ! command -v cyclictest >/dev/null || [ "$(id -u)" -ne 0 ]; then
    printf '\nthe loop against cyclictest: left out, it needs root (SCHED_FIFO)\n'
    exit 0
fi
cyclictest_wake() { # seconds -> p50 p99 p999 max
    cyclictest --quiet --mlockall --policy=fifo --priority=80 --interval=2000 --threads=1 --duration="$1" --histogram=50000 | awk '
        /^[0-9]/ { count[$1 + 0] = $2; total += $2 }
        /^# Max Latencies/ { max = $NF + 0 }
        END {
            n = split("0.5 0.99 0.999", share)
            for (k = 1; k <= n; k++) {
                seen = 0
                for (us = 0; us < 50000 && seen < share[k] * total; us++) seen += count[us]
                printf "%d ", us - 1
            }
            print max
        }'
}
loop_wake() { # about 14 s -> the same
    "$hexid" run --hal sim: --rt require --set motion.engage_s=3 --set motion.park_s=3 --set motion.hold_s=0 --set tests.settle_s=0.2 \
        --set tests.ramp_s=0.2 --set tests.ramp_out_s=0.2 --set tests.duration_s=0.5 --set lcm.url= --log "$work/loop.lcm" \
        --json "$work/loop.json" >"$work/loop.out" 2>&1
    python3 -c 'import json, sys
w = json.load(open(sys.argv[1]))["loop"]["wake_us"]
print(w["p50"], w["p99"], w["p999"], w["max"])' "$work/loop.json" \
        || tail -n 3 "$work/loop.out"
}
for _ in 1 2 3 4; do
    cyclictest_wake 14 >>"$work/wake.cyclictest"
    loop_wake >>"$work/wake.loop"
done
title "wake-up lateness, 4 x 14 s in turns" ""
column=0
for quantile in p50 p99 p999 max; do
    column=$((column + 1))
    for who in cyclictest loop; do awk -v c=$column '{ print $c }' "$work/wake.$who" | row "wake_${who}_$quantile" us 1 ""; done
    paste -d' ' "$work/wake.cyclictest" "$work/wake.loop" | awk -v c=$column '{ print $(c + 4) / ($c ? $c : 1) }' |
        row "wake_ratio_$quantile" x 1 ""
done
