#!/bin/bash
# The output of hexid gap: a page that a browser draws, whole files or none, and a result that does not depend on pictures.
. tests/scenarios/lib
skip_under tsan "hexid gap" "a quarter of an hour under ThreadSanitizer; tests/test_axis.c searches with the same threads"

friction="--set effects.cylinder_coulomb_friction.force_extend_n=60 --set effects.cylinder_coulomb_friction.force_retract_n=60"
quick --tests z --set tests.duration_s=2 $friction --log "$work/run.lcm" >/dev/null
gap() { "$hexid" gap "$work/run.lcm" -c config/tian2015.yaml --set lcm.url= "$@"; }
listed() { [ "$(ls -A "$1" | tr '\n' ' ')" = "$2" ] || { ls -A "$1"; return 1; }; }

columns() { [ -s "$work/text" ] && ! grep -E '.{81}' "$work/text"; }

if [ -n "${MORE_CASES:-}" ]; then # make test-long
    motion() { gap -o "$work/motion" --replay motion >"$work/text" 2>/dev/null && columns && "$python" tests/scenarios/gap_page.py "$work/motion/report.html" 5 "$work"; }
    claim "without a closed loop five pictures are drawn" motion
    rm "$work/run.lcm"
    quick --tests x,phi --set tests.duration_s=2 $friction --log "$work/run.lcm" >/dev/null
    drawn() { gap -o "$work/two" "${@:2}" >/dev/null 2>&1 && "$python" tests/scenarios/gap_page.py "$work/two/report.html" "$1" "$work"; }
    claim "of two axes nine pictures are drawn" drawn 9
    claim "and eight without a closed loop" drawn 8 --replay motion
    exit
fi

whole() { gap -o "$work/out" >"$work/text" && cat "$work/text" && listed "$work/out" "gap.json model.yaml report.html "; }
claim "gap.json, model.yaml and report.html are left, and nothing else" whole
claim "Chromium draws the page: eight pictures, and a first screen of 1280 x 800 with what matters" \
    "$python" tests/scenarios/gap_page.py "$work/out/report.html" 8 "$work"
claim "it is no wider than a telephone" "$python" tests/scenarios/report_view.py "$work/out/report.html" "$work"
claim "the summary fits 80 columns" columns
no_gnuplot() {
    PATH=/nowhere gap -o "$work/plain" >"$work/text" 2>"$work/error"
}
without_pictures() {
    ends 3 no_gnuplot && cat "$work/error" && grep -q 'apt-get install gnuplot-nox' "$work/error" &&
        grep -q cylinder_coulomb_friction "$work/text" && grep -q 'picture not drawn' "$work/plain/report.html" &&
        listed "$work/plain" "gap.json model.yaml report.html "
}
claim "without gnuplot all files are written, the page without pictures, and the status says so" without_pictures
