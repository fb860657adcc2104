#!/bin/bash
# The live page over an hour of a loop's time, as fast as a browser takes it: 3 minutes.
. tests/scenarios/lib
own_network "the live page for an hour"
skip_under 'asan|tsan' "the live page for an hour" "what a sanitizer sees of it, it sees in the scenario"

"$hexid" run --fast --set sim.engine=closed_form --set lcm.url= --log "$work/run.lcm" >"$work/run" 2>&1
hour() {
    "$python" tests/scenarios/live.py hour "$work" "$hexid" "$url" >"$work/hour" 2>&1
    local status=$?
    sed 's/^/# /' "$work/hour" >&3
    return $status
}
claim "an hour of messages makes neither the page nor its server grow" hour 3>&1
