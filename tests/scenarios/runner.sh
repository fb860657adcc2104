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

cat >"$work/slow" <<'END'
#!/bin/sh
[ "$CHECK" ] && printf '# skipped: slow cases, left to make test\nok 1 - fuzzed # SKIP\n' || echo 'ok 1 - fuzzed'
END
chmod +x "$work/slow"
all_slow() {
    CHECK=1 BUILD=$work/build tests/run "$work/slow" >"$work/said" && grep -qx '1 passed, 0 failed' "$work/said" &&
        CHECK=1 BUILD=$work/build tests/run "$work/slow" "$work/some.sh" >>"$work/said" && grep -qx '1 passed, 0 failed' "$work/said"
    local status=$?
    cat "$work/said"
    return $status
}
claim "a fast tier of slow cases alone runs them, and skips them beside others" all_slow

program twin.sh $'ok - holds'
mkdir "$work/other" && cp "$work/twin.sh" "$work/other"
twins() {
    BUILD=$work/build ends 1 tests/run "$work/twin.sh" "$work/other/twin.sh" >"$work/said" 2>&1
    cat "$work/said"
    grep -qx 'two programs have the same name: twin.sh' "$work/said" && grep -qx '0 passed, 1 failed' "$work/said"
}
claim "two programs of one name are refused, since their results would be one" twins

# On a full disk the count's file is there, and empty.
mkdir "$work/full"
cat >"$work/full/awk" <<END
#!/bin/sh
case \$(readlink /proc/\$\$/fd/1) in *.count) exit 2 ;; esac
exec $(command -v awk) "\$@"
END
chmod +x "$work/full/awk"
full() {
    BUILD=$work/build PATH=$work/full:$PATH ends 1 tests/run "$work/twin.sh" >"$work/said" 2>&1
    cat "$work/said"
    grep -qx '# was not run to its end' "$work/said" && grep -qx '0 passed, 1 failed' "$work/said"
}
claim "a program whose count is empty has failed" full
