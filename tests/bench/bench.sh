#!/bin/bash
# `make bench`: what every part of a cycle costs, in time and in instructions, and how the loop compares with the bare machine.
#     bench.sh BUILD
# Prints tables and writes BUILD/bench.csv, whose first line names the build. No figure is judged: on a shared machine only ratios, medians
# and instructions mean something. A figure that cannot be measured ends it with an error. Environment, for a short form: RUNS=15, SHARE=1 (of the
# plant's cycles), SECONDS_OF="5 60 600" (tests that identify is timed on), TURNS=4 (beside cyclictest, 14 s each).
set -uo pipefail
shopt -s lastpipe # an error in a row's pipeline ends the script
build=$1
bench=$build/tests/bench/bench
hexid=$build/hexid
runs=${RUNS:-15}
share=${SHARE:-1}
lengths=${SECONDS_OF:-5 60 600}
turns=${TURNS:-4}
export LC_ALL=C HEXID=$hexid
work=$(mktemp -d "$build/bench.XXXXXX")
trap 'rm -rf "$work"' EXIT
csv=$build/bench.csv
rm -f "$csv"

fail() {
    printf 'bench: %s\n' "$*" >&2
    exit 1
}
for tool in valgrind cyclictest; do command -v $tool >/dev/null || fail "$tool is missing: make deps-bench"; done
version=$("$hexid" --version) || fail "$hexid --version: status $?"
names=$("$bench") && [ -n "$names" ] || fail "$bench: no benchmarks"
printf '# %s\nname,unit,median,p10,p90,runs,instructions\n' "$version" >"$work/csv"
echo "$version"

# Quantiles of the numbers on standard input: p10 median p90.
quantiles() {
    sort -g | awk 'function at(share) { return v[int(1 + share * (NR - 1) + 0.5)] }
        { v[NR] = $1 }
        END { printf "%s %s %s\n", at(0.1), v[int((NR + 1) / 2)], at(0.9) }'
}

# NAME UNIT SCALE INSTRUCTIONS, runs on standard input. A row without runs, or with a run that is not a positive number, is a benchmark that
# did not measure.
row() {
    local name=$1 unit=$2 scale=$3 instructions=$4 count p10 median p90
    awk -v s="$scale" '$1 !~ /^[0-9.]+(e[-+]?[0-9]+)?$/ || !($1 > 0) { exit 1 } { printf "%.4g\n", $1 * s }' >"$work/row" ||
        fail "$name: a run is no number above 0"
    count=$(wc -l <"$work/row")
    ((count > 0)) || fail "$name: nothing was measured"
    read -r p10 median p90 < <(quantiles <"$work/row")
    printf '%-54s %10s %10s %10s  %-6s %12s\n' "$name" "$median" "$p10" "$p90" "$unit" "$instructions"
    echo "$name,$unit,$median,$p10,$p90,$count,$instructions" >>"$work/csv"
}
title() { printf '\n%-40s %10s %10s %10s  %-6s %12s\n' "$1" median p10 p90 unit "$2"; }

# instructions NAME: prints the instructions of one operation.
instructions() {
    local collected operations
    operations=$(valgrind --tool=callgrind --instr-atstart=no --toggle-collect='measured_*' --callgrind-out-file=/dev/null \
        "$bench" "$1" 1 "$share" 2>"$work/callgrind" | awk '{ print $2 }')
    collected=$(awk '/Collected :/ { print $NF }' "$work/callgrind")
    ((${operations:-0} > 0 && ${collected:-0} > 0)) || { tail -n 3 "$work/callgrind" >&2; fail "$1: callgrind counted nothing"; }
    echo $((collected / operations))
}

title "per operation, $runs runs" instructions
for name in $names; do
    "$bench" "$name" "$runs" "$share" >"$work/$name" || fail "$name: $bench ended with status $?"
    count=$(instructions "$name") || exit 1
    awk '{ print $1 }' "$work/$name" | row "$name" us 1e-3 "$count"
done || exit 1

title "simulation against real time, 8 steps a cycle of 2 ms" ""
for name in $(grep sim_step <<<"$names"); do
    awk '{ print 2e6 / (8 * $1) }' "$work/$name" | row "${name/step/real_time_factor}" x 1 ""
done
for name in $(grep sim_step_ode <<<"$names"); do
    awk '{ print $3 }' "$work/$name" | row "${name/step/over_dWorldStep}" x 1 ""
done

# Logs of six tests each. They come from the closed-form engine, because the simulation is not timed here. The first reading warms the
# cache.
title "hexid identify LOG (warm cache)" "max RSS"
for seconds in $lengths; do
    log=$work/$seconds.lcm
    "$hexid" run --hal sim: --fast --set sim.engine=closed_form --set tests.duration_s="$seconds" --set lcm.url= --log "$log" \
        >"$work/run" 2>&1 || { tail -n 3 "$work/run" >&2; fail "hexid run for identify ended with an error"; }
    [ -s "$log" ] || fail "hexid run for identify left no log"
    for _ in 0 1 2 3; do
        rm -f "$work/identify.json"
        "$bench" use "$hexid" identify "$log" --json "$work/identify.json" >"$work/used" 2>"$work/identify" ||
            { tail -n 3 "$work/identify" >&2; fail "hexid identify LOG ended with an error"; }
        [ -s "$work/identify.json" ] || fail "hexid identify left no result"
        tail -n 1 "$work/used" >>"$work/use.$seconds"
    done
    tail -n +2 "$work/use.$seconds" >"$work/use"
    awk '{ print $1 }' "$work/use" | row "identify_6_x_${seconds}_s" s 1 "$(awk '$2 > m { m = $2 } END { print m " kB" }' "$work/use")"
    rm -f "$log"
done

# Compares the loop in real time with the bare machine, in turns, so that both run in the same minutes. `make bench-rt` measures all of it.
if ((turns == 0)) || ! chrt -f 80 true 2>/dev/null; then
    printf '\nthe loop against cyclictest: left out, %s\n' "$( ((turns)) && echo 'this user has no SCHED_FIFO: run as root' || echo 'TURNS=0')"
else
    for _ in $(seq "$turns"); do
        for who in cyclictest loop; do tests/rt/wake.py $who 14 >>"$work/wake.$who" || fail "the loop beside cyclictest: status $?"; done
    done
    title "wake-up lateness, $turns x 14 s in turns" ""
    column=0
    for quantile in p50 p99 p999 max; do
        column=$((column + 1))
        for who in cyclictest loop; do awk -v c=$column '{ print $c }' "$work/wake.$who" | row "wake_${who}_$quantile" us 1 ""; done
        paste -d' ' "$work/wake.cyclictest" "$work/wake.loop" | awk -v c=$column '{ print $(c + 6) / $c }' | row "wake_ratio_$quantile" x 1 ""
    done
fi
mv "$work/csv" "$csv"
