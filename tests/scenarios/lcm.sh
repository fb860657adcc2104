#!/bin/bash
# The stream as others see it: LCM's own logger and Python library receive, in a network of their own, what a run publishes.
if [ "${1:-}" != inside ]; then
    for namespace in "unshare -n" "unshare -Urn"; do
        $namespace true 2>/dev/null && exec $namespace "$0" inside
    done
    echo "ok - other programs receive the stream # SKIP this machine allows no network namespace"
    exit
fi

. tests/scenarios/lib
url='udpm://239.255.76.67:7667?ttl=0'

ip link set lo up
ip link set lo multicast on
ip route add 224.0.0.0/4 dev lo
lcm-gen -p --ppath "$work" lcmtypes/*.lcm

# Both receivers have joined the multicast group.
listening() { [ -e "$work/ready" ] && awk '$1 == "434CFFEF" { users += $2 } END { exit users < 2 }' /proc/net/igmp; }

PYTHONPATH=$work "$python" tests/peers/listen.py "$url" "$work/ready" >"$work/python" 2>"$work/python.error" &
listener=$!
lcm-logger --lcm-url="$url" --quiet "$work/logger.lcm" >"$work/logger" 2>&1 &
logger=$!
until listening; do
    { kill -0 $listener && kill -0 $logger; } 2>/dev/null || { cat "$work/python.error" "$work/logger"; break; }
    sleep 0.05
done
quick --set lcm.url="$url" --set lcm.state_every=100 --log "$work/run.lcm" >"$work/run" 2>&1
wait $listener
kill -INT $logger
wait $logger

received() { cat "$work/python" "$work/python.error" "$work/run"; grep -q "^$1 $2 " "$work/python"; }
small() { cat "$work/python"; awk '$1 == "HEXID_STATE" { size = $3 } END { exit !(size > 0 && size <= 600) }' "$work/python"; }
logged() {
    "$python" -c 'import lcm, sys
counts = {}
for event in lcm.EventLog(sys.argv[1], "r"): counts[event.channel] = counts.get(event.channel, 0) + 1
print(counts)
sys.exit(counts.get("HEXID_TEST_RESULT") != 6 or counts.get("HEXID_IDENTIFICATION") != 1)' "$work/$1"
}

claim "LCM's Python library receives six test results" received HEXID_TEST_RESULT 6
claim "and one identification" received HEXID_IDENTIFICATION 1
claim "a state message has at most 600 bytes" small
claim "lcm-logger records six test results and one identification" logged logger.lcm
claim "hexid's own log, read by LCM's library, has them too" logged run.lcm
