#!/bin/bash
# The documents' statements about the program match the program.
. tests/scenarios/lib

failures() {
    "$hexid" doctor --failures >"$work/failures" && [ "$(wc -l <"$work/failures")" -gt 10 ] &&
        while IFS= read -r line; do grep -qxF -- "$line" docs/safety.md || { echo "not there: $line"; return 1; }; done <"$work/failures"
}
claim "the table of what can fail in docs/safety.md is the program's" failures

printed() { diff <(sed "1,/^<!-- hexid doctor $2 -->$/d" "docs/$1") <("$hexid" doctor "$2"); }
claim "docs/configuration.md has the program's keys (otherwise: make docs)" printed configuration.md --keys
claim "docs/troubleshooting.md has the program's reasons to exclude samples and tests (otherwise: make docs)" printed troubleshooting.md --refusals

# The flags of samples are taken together, as REFUSED_STALE + bit.
decided() {
    local reason
    for reason in $(sed -n '/REFUSED_NO_NUMBER/,/REFUSALS/p' src/recording/refusal.h | grep -o 'REFUSED_[A-Z_]*') REFUSED_STALE; do
        grep -rqw "$reason" src --include=*.c --exclude=refusal.c || { echo "$reason: decided nowhere"; return 1; }
    done
}
claim "every reason to exclude something is one that the code decides by" decided

# The values depend on one machine and its libraries, so everything but the digits is compared.
shape() { sed -E 's/-?[0-9][0-9.e-]*/N/g; s/ +/ /g; s/^ //' "$@"; }
checked() {
    quick --set tests.duration_s=2 --log "$work/a.lcm" >/dev/null 2>&1
    "$hexid" check "$work/a.lcm" | shape >"$work/check" &&
        sed -n '/hexid check runs\/a.lcm -o runs\/a.html --json/,/would take it$/p; /hexid gap would take it$/p' docs/your-data.md | grep '^      ' |
        grep -vE '^ *(\.\.\.|x: )' | shape >"$work/page"
    [ "$(wc -l <"$work/page")" -ge 8 ] &&
        while IFS= read -r line; do grep -qxF -- "$line" "$work/check" || { echo "not there: $line"; cat "$work/check"; return 1; }; done <"$work/page"
}
claim "the example of check in docs/your-data.md is what the program prints" checked
