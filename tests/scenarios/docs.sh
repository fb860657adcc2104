#!/bin/bash
# What the documents say of the program is what the program says.
. tests/scenarios/lib

failures() {
    "$hexid" doctor --failures >"$work/failures" && [ "$(wc -l <"$work/failures")" -gt 10 ] &&
        while IFS= read -r line; do grep -qxF -- "$line" README.md || { echo "not there: $line"; return 1; }; done <"$work/failures"
}
claim "the README's table of what can fail is the program's" failures
