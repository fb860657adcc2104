#!/bin/bash
# The pages' links work, and the commands that README.md and the tutorial tell a reader to type work and print what they show. Commands run
# in their own directory, which contains the repository's build/, config/ and tests/. Commands that are not run are marked (pages.py).
. tests/scenarios/lib
skip_under 'asan|tsan' "the commands of the pages" "the same code runs in the other scenarios"

pages=$PWD/tests/scenarios/pages.py
here() { mkdir "$work/$1" && cd "$work/$1" && mkdir build && ln -s "$hexid" build/hexid && ln -s "$OLDPWD/config" "$OLDPWD/tests" .; }
# typed PAGE NAME: all its commands in one shell, to the end of the last one.
typed() { "$python" "$pages" commands "$1" >"$work/$2.sh" && (here "$2" && bash -eu "$work/$2.sh") >"$work/$2.out" 2>&1 || { tail -n 40 "$work/$2.out"; return 1; }; }
# The values depend on one machine and its libraries, so everything but the digits is compared.
shape() { sed -E 's/[-+]?[0-9][0-9.e-]*/N/g; s/ +/ /g; s/^ //' "$@"; }
printed() {
    shape "$work/$2.out" >"$work/$2.lines"
    "$python" "$pages" shown "$1" | shape | sed '/^$/d' >"$work/$2.shown"
    [ "$(wc -l <"$work/$2.shown")" -ge 5 ] &&
        while IFS= read -r line; do grep -qxF -- "$line" "$work/$2.lines" || { echo "not printed: $line"; return 1; }; done <"$work/$2.shown"
}
if [ -n "${MORE_CASES:-}" ]; then # make test-long
    claim "the commands of the tutorial work" typed docs/tutorial.md tutorial
    claim "and print what it shows" printed docs/tutorial.md tutorial
    claim "the commands of docs/report.md work" typed docs/report.md report
    exit
fi

claim "every link, anchor and file that the pages name is there; README.md has at most 150 lines" "$python" tests/scenarios/pages.py links

claim "every message of docs/troubleshooting.md is one of the program's" "$python" tests/scenarios/pages.py messages

claim "the commands of README.md work" typed README.md readme
# README.md's first command is make run, which uses the wall clock. --fast makes the same log here.
(cd "$work/readme" && mkdir runs && build/hexid run --fast --set sim.engine=closed_form --log runs/a.lcm) >>"$work/readme.out" 2>/dev/null
claim "and print what it shows" printed README.md readme
made() { for target in $(sed -n 's/^make \([a-z-]*\) .*/\1/p' README.md); do make -n "$target" >/dev/null || return 1; done; }
claim "README.md's make targets are there" made
