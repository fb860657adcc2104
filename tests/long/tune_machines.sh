#!/bin/bash
# Twenty machines over two decades of mass with the default's gains (tests/long/tune_machines.py): with the gains of hexid tune each engages,
# passes its six tests, and measures the margins that were predicted.
. tests/scenarios/lib
skip_under 'asan|tsan' "twenty tuned machines" "hours under a sanitizer"

"$hexid" run --print-config -c config/tian2015.yaml | "$python" tests/long/tune_machines.py "$work" 20 >"$work/drawn"

drives() {
    local status
    "$hexid" tune -c "$1" -o "$1.tuned" >"$work/tune"
    status=$?
    grep -E "^  (gain|phase|damping of)|not reached" "$work/tune"
    ((status <= 1)) && ends 0 "$hexid" run --fast -c "$1.tuned" --set sim.engine=closed_form --set lcm.url= >"$work/out" 2>&1 || { cat "$work/out"; return 1; }
    ! grep -E "FAULT|warning: gains" "$work/out"
}
while read -r machine; do
    claim "$(head -n 1 "$machine"): engages and passes its tests" drives "$machine"
done <"$work/drawn"
mapfile -t machines <"$work/drawn"
CMOCKA_MESSAGE_OUTPUT=STDOUT "${BUILD:-build}/tests/test_loop_tune" "${machines[@]}" >"$work/margins" 2>&1
claim "the margins of all of them are those that were predicted" test $? -eq 0
sed -n 's/^# /# /p' "$work/margins"
