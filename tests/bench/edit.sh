#!/bin/bash
# From an edit of one module to the verdict of its tests: processor seconds of `make check T=MODULE`,
# building included, each module in turn. The first line is a run without an edit.
#     tests/bench/edit.sh [MODULE...]
cd "$(dirname "$0")/../.." || exit 1
modules=${*:-platform search residual method_c csv_map operator can_master cylinder gap_text frequency}
TIMEFORMAT='%U %S'
for module in $modules; do
    make check T="$module" >/dev/null || exit # builds what an earlier change left unbuilt
done
for module in "" $modules; do
    [ -z "$module" ] || touch -c {src/*,hal,sim}/"$module".c 2>/dev/null
    used=$({ time make check T="${module:-platform}" >"${BUILD:-build}/edit.log" 2>&1; } 2>&1)
    awk -v m="${module:-none}" -v used="$used" '/ passed, .* failed$/ { verdict = $0 }
        END { split(used, s, " "); printf "%-12s %5.1f s  %s\n", m, s[1] + s[2], verdict }' "${BUILD:-build}/edit.log"
done
