#!/bin/bash
# The stream as others see it: LCM's own logger and Python library receive a run's messages in a network of their own.
. tests/scenarios/lib
own_network "LCM's own programs receive the stream"

mkfifo "$work/input"
"$python" tests/peers/subscriber.py "$work" "$url" "$work/ready" <"$work/input" >"$work/python" 2>"$work/python.error" &
listener=$!
lcm-logger --lcm-url="$url" --flush-interval=1 --quiet "$work/logger.lcm" >"$work/logger" 2>&1 &
logger=$!
exec 3>"$work/input" # the listener ends when this is closed
until [ -e "$work/ready" ] && [ "$(listeners)" -ge 2 ]; do
    { kill -0 $listener && kill -0 $logger; } 2>/dev/null || { cat "$work/python.error" "$work/logger"; break; }
    sleep 0.05
done
# comes WORD FILE: waits up to a minute for WORD in FILE.
comes() {
    for _ in $(seq 1200); do
        grep -qs "$1" "$2" && return
        sleep 0.05
    done
}
# Runs by the wall clock: lcm-logger queues 30 messages, and a faster run would overflow it while it waits for the processor.
"$hexid" run --hal sim: --rt off "${quick_settings[@]}" --set lcm.url="$url" --set lcm.state_every=100 --set tests.duration_s=2 --log "$work/run.lcm" \
    --json "$work/run.json" >"$work/run" 2>&1
quick --set lcm.url= --tests x --set tests.duration_s=2 --log "$work/x.lcm" >>"$work/run" 2>&1
"$hexid" gap --measured "$work/x.lcm" -c config/tian2015.yaml --set lcm.url="$url" -o "$work/gap" >>"$work/run" 2>&1
comes HEXID_GAP "$work/python" # the listener ends at once, whatever waits in its socket
exec 3>&-
wait $listener
comes HEXID_IDENTIFICATION "$work/logger.lcm" # ended by a signal, the logger drops unwritten messages
kill -INT $logger
wait $logger

received() {
    cat "$work/python.error" "$work/run"
    local count
    count=$(grep -c "\"channel\": \"$1\"" "$work/python")
    echo "$count of $1"
    [ "$count" -eq "$2" ]
}
logged() {
    "$python" -c 'import lcm, sys
count, size = {}, {}
for event in lcm.EventLog(sys.argv[1], "r"):
    count[event.channel] = count.get(event.channel, 0) + 1
    size[event.channel] = max(size.get(event.channel, 0), len(event.data))
print(count, size)
complete = count.get("HEXID_TEST_RESULT") == 6 and count.get("HEXID_IDENTIFICATION") == 1
sys.exit(not complete or not 0 < size.get("HEXID_STATE", 0) <= 600)' "$work/$1"
}

claim "LCM's Python library receives six test results" received HEXID_TEST_RESULT 6
claim "and one identification" received HEXID_IDENTIFICATION 1
claim "and what hexid gap found" received HEXID_GAP 1
claim "lcm-logger records both, and no state of more than 600 bytes" logged logger.lcm
# The last message covers all six tests: the result's own numbers. Of tests that end during an estimation only the last counts, so there are
# at least three.
estimated() {
    "$python" - "$work" <<'END'
import json, sys
lines = (json.loads(line) for line in open(f"{sys.argv[1]}/python"))
estimates = [line["message"] for line in lines if line["channel"] == "HEXID_METHOD_C"]
c = json.load(open(f"{sys.argv[1]}/run.json"))["method_c"]
print([(e["tests"], e["determined"]) for e in estimates])
assert 3 <= len(estimates) <= 6
assert all(a["tests"] < b["tests"] and a["determined"] <= b["determined"] for a, b in zip(estimates, estimates[1:]))
last = estimates[-1]
assert last["tests"] == 6 and last["determined"] == 21
assert last["mt_si"] == c["Mt"] and last["mt_std_si"] == c["std"] and last["dry_retract_n"] == c["dry_friction_n"]["retract"]
assert last["viscous_n_s_per_m"] == c["viscous_n_s_per_m"] and last["condition"] == c["condition_number"]
first = estimates[0]
assert first["determined"] < 21 and "nan" in sum(first["mt_si"], [])
END
}
claim "after each test method C's estimate so far, the last one the result to the last bit" estimated
again() {
    for log in 1 2; do quick --set tests.duration_s=2 --tests x,y --set lcm.url="$url" --log "$work/again$log.lcm" >/dev/null; done
    cmp "$work/again1.lcm" "$work/again2.lcm" && grep -q HEXID_METHOD_C "$work/again1.lcm"
}
claim "in virtual time they stand in the log at the same place every time" again
claim "hexid's own log, read by LCM's library, has them too" logged run.lcm
