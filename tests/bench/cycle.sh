#!/bin/bash
# Instructions of platform_step(), one cycle of the controller: best, median and worst by state, healthy and with faults (cycle.c,
# callgrind).
#     cycle.sh BUILD
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
states=(init settled engaging ready testing parking fault pressurising)
echo "$("$1/hexid" --version)"
printf '\n| faults injected | state, latched | cycles | best | median | worst |\n| --- | --- | --- | --- | --- | --- |\n'
for fault in "" nan@3+0.5 drop@3+0.01 stale@3+1 length@3+1/2=0.05 pressure_nan@3+1 emergency_stop@3+1 noise@2.5+1=0.0003; do
    rm -f "$work"/c*
    valgrind --tool=callgrind --instr-atstart=no --toggle-collect=platform_step --callgrind-out-file="$work/c" "$1/tests/bench/cycle" $fault \
        >"$work/names" 2>"$work/said" || { tail -n 3 "$work/said" >&2; exit 1; }
    find "$work" -name 'c.*' -exec grep -hE '^desc: Trigger: Client|^totals' {} + | paste - - | awk '{ print $5, $6, $NF }' | sort -k1,1n -k2,2n -k3,3n |
        awk -v fault="${fault:-none}" -v names="${states[*]}" '
            function row() { if (n) printf "| %s | %s%s | %d | %d | %d | %d |\n", fault, state[was + 1], latched ? ", fault" : "", n, v[1], v[int((n + 1) / 2)], v[n] }
            BEGIN { split(names, state, " ") }
            NR > 1 && ($1 != was || $2 != latched) { row(); n = 0 }
            { was = $1; latched = $2; v[++n] = $3; if (!($3 > 0)) bad = 1 }
            END { row(); if (!NR || bad) { print "cycle: nothing was counted" > "/dev/stderr"; exit 1 } }'
done
