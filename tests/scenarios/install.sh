#!/bin/bash
# Installed, hexid needs no checkout: it finds its configuration, has a manual page for every subcommand, and a help with options and an
# example. A misspelt word gets a suggestion.
. tests/scenarios/lib

# Works on a copy, because other tests run the program meanwhile, and a commit in between would relink it.
mkdir "$work/build" && cp "$hexid" "$work/build/"
make_install() { make --no-print-directory BUILD="$work/build" -o "$work/build/hexid" "$@" install; }
readme() {
    "$python" tests/scenarios/pages.py commands "$work/opt/share/doc/hexid/README.md" >"$work/readme.sh" && mkdir "$work/reader" &&
        (cd "$work/reader" && PATH=$work/opt/bin:$PATH bash -eu "$work/readme.sh") && [ -s "$work/reader/stand-gap/report.html" ]
}
if [ -n "${MORE_CASES:-}" ]; then # make test-long; make test runs the README's commands in pages.sh
    make_install prefix="$work/opt" >/dev/null
    claim "the installed README's commands work from an empty directory" readme
    exit
fi
root=$work/root
installed() { make_install DESTDIR="$root" prefix=/usr >"$work/installed" 2>&1 || { cat "$work/installed"; return 1; }; }
claim "make install with DESTDIR writes below it" installed
# Runs from another directory with an empty environment.
mkdir "$work/elsewhere"
own() { (cd "$work/elsewhere" && env -i "$root/usr/bin/hexid" "$@"); }

names=$("$hexid" --help | sed -n 's/^  hexid \([a-z]\{1,\}\) .*/\1/p')
runs() { own run "${quick_settings[@]}" --fast --log a.lcm --json a.json && own identify a.lcm --json b.json && cmp "$work/elsewhere/"{a,b}.json; }
claim "installed, it runs and identifies from a directory of its own" runs
configuration() { own doctor --latency 0 --set lcm.url= | grep -F "$root/usr/bin/../../etc/hexid/tian2015.yaml"; }
claim "it finds its configuration in the root that it was installed in" configuration
under_prefix() {
    make_install prefix="$work/opt" >/dev/null && [ -s "$work/opt/etc/hexid/tian2015.yaml" ] &&
        (cd "$work/elsewhere" && env -i "$work/opt/bin/hexid" doctor --latency 0 --set lcm.url= | grep -F "$work/opt/bin/../etc/hexid/tian2015.yaml") &&
        grep -q "^ExecStart=$work/opt/bin/hexid run" "$work/opt/lib/systemd/system/hexid.service"
}
claim "under a prefix of its own the same, and the unit names it" under_prefix
claim "the installed pages lead somewhere, and name no path of a checkout" \
    "$python" tests/scenarios/pages.py installed "$work/opt/share/doc/hexid"
version() { own --version | grep -xE 'hexid [0-9]+\.[0-9]+\.[0-9]+( \(commit [0-9a-f]{12}\+?\))?' && own --version | grep -F "$(sed -n 's/^VERSION := //p' Makefile)"; }
claim "--version is the Makefile's, with the commit of a checkout" version
claim "the changelog begins with that version" eval '[ "$(sed -n "s/^## \(.*\), [0-9-]*\$/\1/p" docs/changelog.md | head -n 1)" = "$(sed -n "s/^VERSION := //p" Makefile)" ]'

explained() {
    for name in $names; do
        own "$name" --help >"$work/help" && grep -qx 'Options:' "$work/help" && grep -qx 'Example:' "$work/help" &&
            [ "$(tail -n 1 "$work/help" | cut -d' ' -f3,4)" = "hexid $name" ] || { echo "$name"; cat "$work/help"; return 1; }
    done
    [ "$(wc -w <<<"$names")" -ge 11 ]
}
claim "every subcommand's help has options and an example" explained
# Every option of a usage line is explained below it, and the program accepts every explained one.
agrees() {
    for name in $names; do
        own "$name" --help | awk '/^Options:/ { exit } { print }' | sed "s,\`[^\`]*\`,,g" | grep -oE -- '(^|[[ ])--?[a-z][a-z-]*' | tr -d '[ ' | sort -u >"$work/usage"
        own "$name" --help | sed -n '/^Options:$/,/^Example:$/p' | grep -oE -- '^  --?[a-z-]+' | tr -d ' ' | sort -u >"$work/listed"
        comm -23 "$work/usage" "$work/listed" | grep . && { echo "$name: not explained"; return 1; }
        while read -r option; do
            [ "$name $option" = "monitor --json" ] && continue # never ends
            own "$name" "$option" --nothing --nothing 2>&1 </dev/null | grep -F "has no option $option" && { echo "$name"; return 1; } # without a run
        done < <(grep -- '--' "$work/listed" | grep -vxE -- '--(fast|print-config|modbus-map|failures|refusals|keys|once)')
    done
    return 0
}
claim "a usage line, the options below it and the program agree" agrees
suggests() { refuses 2 "did you mean $1" own "${@:2}"; }
claim "a misspelt subcommand gets a suggestion" suggests 'identify?' idenitfy a.lcm
claim "so does a misspelt option, one of the subcommand's" suggests '--trajectory?' run --trajectroy x
claim "so does a command to the platform" suggests 'start?' command strat
claim "and an effect, of which a beginning is enough" suggests 'cylinder_coulomb_friction?' effects cylinder_coul
nothing_near() { refuses 2 "no such subcommand: frobnicate" own frobnicate && ! grep 'did you mean' "$work/error"; }
claim "a word that nothing is near gets none" nothing_near

pages() {
    for page in "$root"/usr/share/man/man1/*.1; do
        MANWIDTH=100 man -l --warnings=all,w -E UTF-8 "$page" >"$work/page" 2>"$work/warned" && ! grep . "$work/warned" && grep -q '^NAME' "$work/page" ||
            { echo "$page"; cat "$work/warned"; return 1; }
    done
    [ "$(ls "$root/usr/share/man/man1" | wc -l)" -eq $(($(wc -w <<<"$names") + 1)) ] && MANWIDTH=100 man -l "$root/usr/share/man/man1/hexid-run.1" | grep -q -- '--log-quota GB'
}
if command -v man >/dev/null; then claim "a manual page for each, which man renders without a warning" pages
else echo "ok - a manual page for each, which man renders without a warning # SKIP no man here"; fi
completes() {
    . "$root/usr/share/bash-completion/completions/hexid"
    compopt() { :; }
    complete_() { COMP_WORDS=("$root/usr/bin/hexid" "$@") COMP_CWORD=$#; _hexid "$root/usr/bin/hexid"; }
    complete_ ide && [ "${COMPREPLY[*]}" = identify ] && complete_ run --trj && [ ${#COMPREPLY[@]} -eq 0 ] && complete_ run --tra &&
        [ "${COMPREPLY[*]}" = --trajectory ] && complete_ run --rt req && [ "${COMPREPLY[*]}" = require ] && complete_ gap --set payload.mass &&
        [ "${COMPREPLY[*]}" = payload.mass_kg= ]
}
claim "bash completes subcommands, options, choices and keys" completes

logs() {
    mkdir "$work/logs"
    for day in 1 2; do
        head -c 3000000 /dev/zero >"$work/logs/2026-01-0${day}T00-00-00Z.lcm"
        touch -d 2026-01-0$day "$work/logs/2026-01-0${day}T00-00-00Z.lcm"
    done
    quick --log "$work/logs" --log-quota 0.004 >"$work/said" && ls -l "$work/logs" && [ "$(ls "$work/logs" | wc -l)" -eq 2 ] &&
        [ -e "$work/logs/2026-01-02T00-00-00Z.lcm" ] && log=$(sed -n 's/^log *//p' "$work/said") && [ -s "$log" ] || return
    quick --log "$work/logs" --log-quota 0.000001 >/dev/null && ls -l "$work/logs" && [ "$(ls "$work/logs" | wc -l)" -eq 2 ] &&
        ends 0 "$hexid" identify "$log" >/dev/null # the earlier log is still there, whatever the quota
}
claim "logs in a directory have names of their own; beyond the quota the oldest go, and the newest stays" logs
claim "a quota without a directory is refused" refuses 2 "--log-quota DIR" quick --log "$work/x.lcm" --log-quota 1
claim "a quota that is no number is refused" refuses 2 "--log-quota much" quick --log "$work/logs" --log-quota much
