#!/bin/bash
# The scorecard of hexid gap on this machine's cores: draws the cases, runs each, keeps a line of CSV a case, prints the figures.
#     SEEDS=2 FIRST=1 tests/gap/bench.sh BUILD
# EFFECTS=A,B KINDS=single SIZES=typical narrow the draw. Cases are independent of each other: docs/validation.md has the line that spreads
# them over other machines. Ends with an error where a case is missing from the table, or its rig did not run.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=$(realpath -m "$1")/gap_score
export HEXID=$(realpath "$1/hexid")
score=tests/gap/score.py
build=$("$HEXID" --version)
mkdir -p "$out"
rm -f "$out/score.csv"
export DETECTABLE=$out/detectable.csv
# shellcheck disable=SC2086 # names of effects, or none
"$1/tests/bench/signatures" "$DETECTABLE" ${EFFECTS//,/ }
draw() { $score cases --first "${FIRST:-1}" --seeds "${SEEDS:-1}" --effects "${EFFECTS:-}" "$@"; }
{
    draw --kinds "${KINDS:-single,none,two,unknown}" --sizes "${SIZES:-detectable,typical,strong}"
    [ -n "${KINDS:-}" ] || draw --kinds single,none --series beyond
} >"$out/cases"
count=$(wc -l <"$out/cases")
echo "$count cases -> $out/score.csv"
((count > 0)) || { echo "bench-gap: no case was drawn" >&2; exit 1; }
echo "# $build" >"$out/score.csv.part"
xargs -a "$out/cases" -P "$(nproc)" -L 1 $score case >>"$out/score.csv.part"
rows=$(grep -vc '^#' "$out/score.csv.part") || true
((rows == count)) || { echo "bench-gap: $rows rows of $count cases" >&2; exit 1; }
if grep 'the rig does not run' "$out/score.csv.part" >&2; then
    echo "bench-gap: the rig did not run in the cases above" >&2
    exit 1
fi
mv "$out/score.csv.part" "$out/score.csv"
$score report "$out/score.csv" -o "$out/report.html"
echo "$out/report.html"
