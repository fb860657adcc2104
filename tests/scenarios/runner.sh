#!/bin/bash
# tests/run counts skipped claims, and prints the reason of each: a scenario's reason stands behind "# SKIP", a C test's in the line before.
# Depending on its version, cmocka writes a skipped test as "ok" or "not ok", with its name before or behind "# SKIP".
. tests/scenarios/lib

program() {
    printf '#!/bin/sh\ncat <<"END"\n%s\nEND\n' "$2" >"$work/$1"
    chmod +x "$work/$1"
}
program test_old $'1..4\nok 1 - works\n# skipped: no root\nnot ok 2 # SKIP needs_root\nnot ok 3 # SKIP says_nothing\n# skipped: no bus\nnot ok 4 # SKIP needs_a_bus'
program test_new $'1..2\n# skipped: no root\nok 1 - needs_root_too # SKIP\nok 2 - works'
program some.sh $'ok - holds\nok - a claim # SKIP no network\nok - another # SKIP no network'
BUILD=$work/build tests/run "$work/test_old" "$work/test_new" "$work/some.sh" >"$work/said" 2>&1

every_reason() {
    cat "$work/said"
    for line in 'test_old: needs_root: no root' 'test_old: says_nothing: no reason given' 'test_old: needs_a_bus: no bus' \
        'test_new: needs_root_too: no root' 'some.sh: a claim: no network' 'some.sh: another: no network'; do
        grep -qxF "skipped, $line" "$work/said" || { echo "missing: $line"; return 1; }
    done
    [ "$(grep -c '^skipped, ' "$work/said")" = 6 ]
}
claim "every skipped claim is listed, with its reason" every_reason
claim "and counted neither as passed nor as failed" grep -qx '6 skipped' "$work/said"
claim "what passed is counted" grep -qx '3 passed, 0 failed' "$work/said"
