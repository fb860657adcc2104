#!/bin/bash
# The scorecard of hexid gap on this machine's cores: draws the cases, runs each, keeps a line of CSV a case, prints the figures.
#     SEEDS=2 FIRST=1 tests/gap/bench.sh BUILD
# Cases are independent of each other: docs/validation.md has the line that spreads them over other machines.
set -eu
cd "$(dirname "$0")/../.."
out=$(realpath -m "$1")/gap_score
export HEXID=$(realpath "$1/hexid")
score=tests/gap/score.py
mkdir -p "$out"
export DETECTABLE=$out/detectable.csv
"$1/tests/bench/signatures" "$DETECTABLE"
{
    $score cases --first "${FIRST:-1}" --seeds "${SEEDS:-1}" --kinds single,none,two,unknown --sizes detectable,typical,strong
    $score cases --first "${FIRST:-1}" --seeds "${SEEDS:-1}" --kinds single,none --series beyond
} >"$out/cases"
echo "$(wc -l <"$out/cases") cases -> $out/score.csv"
xargs -a "$out/cases" -P "$(nproc)" -L 1 $score case >"$out/score.csv"
$score report "$out/score.csv" -o "$out/report.html"
echo "$out/report.html"
