#!/bin/bash
# The fault campaign on Modbus TCP, in real time: three minutes.
. tests/scenarios/lib
. tests/scenarios/modbus_lib
lcm-gen -p --ppath "$work" lcmtypes/*.lcm
S=("${quick_settings[@]}")
ahead=$(chrt -f 70 true 2>/dev/null && echo chrt -f 70)

# Orders to the proxy and the run's lines; held open at both ends, so that nobody waits for or dies of an end that is gone.
mkfifo "$work/orders" "$work/lines"
exec 4<>"$work/lines" 5<>"$work/orders"

# What befalls the line; where the proxy does it, the proxy says when.
order() { echo "$1" >&5; }
stop_daemon() { kill -STOP $run; sleep 1; kill -CONT $run; }
stop_plant() { kill -STOP $plant; }
restart() { { plant_stop -KILL; plant_start "tcp://127.0.0.1:${url##*:}" "${S[@]}"; } 2>/dev/null; }

# begin HAL: the run, against the plant through the proxy.
begin() {
    rm -f "$work/proxy" "$work/fault.lcm" "$work/fault.json"
    plant_start tcp://127.0.0.1:0 "${S[@]}" || return
    $ahead "$python" tests/peers/modbus_proxy.py "${url##*:}" <"$work/orders" >"$work/proxy" &
    proxy=$!
    until [ -s "$work/proxy" ]; do kill -0 $proxy || return; done
    "$hexid" run --hal "$1modbus:tcp://127.0.0.1:$(head -n 1 "$work/proxy")" "${S[@]}" --set motion.automatic=true \
        --log "$work/fault.lcm" --json "$work/fault.json" >"$work/lines" 2>&1 &
    run=$!
}

# Until the first test is over.
begun() {
    local line
    while read -r -t 60 -u 4 line; do
        [[ $line == *"test 1/6"* ]] && return
        [[ $line == *FAULT* || $line == verdict* || $line == hexid:* ]] && break
    done
    echo "$name: the run ended before its first test did: $line" >&2
    kill $run 2>/dev/null
    return 1
}

ended() {
    local status fd
    wait $run
    status=$?
    kill $proxy || echo "$name: exit status of the proxy" >&2
    kill -CONT $plant
    plant_stop
    for fd in 4 5; do while read -r -t 0 -u $fd; do read -r -u $fd; done; done
    ((status == 0 || status == 1)) || echo "$name: exit status $status" >&2
}

# fault NAME|WHAT|EXPECTED|WITHIN: WHAT is an order to the proxy, a function above, or a fault of hal/fault.c from 3 s on.
fault() {
    local name what expected within from=3 hal plant url proxy run
    IFS='|' read -r name what expected within <<<"$1"
    [[ $what == *@* ]] && hal="fault:$what;" || hal=
    begin "$hal" || { echo "$name: plant or proxy do not start" >&2; return; }
    if [ -z "$hal" ]; then
        begun || { ended; return; }
        from=@${EPOCHREALTIME/./}
        if declare -F "$what" >/dev/null; then $what; else order "$what"; fi
    fi
    ended
    [ "$(wc -l <"$work/proxy")" -eq 2 ] && from=@$(tail -n 1 "$work/proxy")
    PYTHONPATH=$work "$python" tests/scenarios/faults.py "$name" "$from" "$expected" "$within" "$work/fault.lcm" "$work/fault.json" "$work/clean.json"
}

listed() {
    bus_campaign <<'END'
answers lost 1 %|loss 1|flagged|900
answers lost 10 %|loss 10|flagged|90
answers lost 100 %|loss 100|sensor_age/io|25
answers delayed 3 ms|delay 3|flagged|10
answers delayed 20 ms|delay 20|sensor_age/io|25
answers twice 20 %|twice 20|nothing/flagged|0
bit flips in 10 % of the answers|flip 10|flagged/leg_rate/stroke/sensor_invalid/force/following_error|0
wrong transaction numbers|number|sensor_age/io|25
exceptions|exception|sensor_age/io|25
half answers|half|sensor_age/io|25
connection reset|reset|io|40
server hangs|hang|sensor_age/io|40
server stopped|stop_plant|sensor_age/io|25
server restarted|restart|sensor_age/io|25
daemon stopped for 1 s|stop_daemon|overrun/sensor_age|25
length frozen|freeze@3+100/3|standstill/verdict|0
not a number|nan@3+100/2|sensor_invalid|5
length out of range|length@3+100/3=1|stroke|5
length jumps 10 mm|length@3+100/3=0.01|leg_rate|5
lengths of legs 2 and 3 swapped|swap@3+100/2|following_error/leg_rate/verdict|0
pressure out of range|pressure@3+100/3=2e7|sensor_invalid|5
pressures of legs 2 and 3 swapped|mix@0.05+100/2|verdict|0
END
}
claim "a run without a fault passes" tries 3 run_tcp "${S[@]}"
mv "$work/run.json" "$work/clean.json"
claim "every fault on Modbus is detected in time or harmless, and never identified wrongly in silence" listed
sed 's/^/# /' "$work/claim.out"

# The device's watchdog and the log, after a kill: the plant itself is asked, not through the proxy.
killed() {
    local name="daemon killed in a test" plant url proxy run killed_us
    begin "" && begun || return
    "$python" - "${url##*:}" >"$work/asked" <<'END' &
import socket, struct, sys, time
plant = socket.create_connection(("127.0.0.1", int(sys.argv[1])))
print("asks", flush=True)
silent = False
while not silent:
    plant.sendall(b"\0\1\0\0\0\6\1\3\0\x21\0\1")  # MODBUS_STATUS
    silent = plant.recv(260)[10] & 1
print(time.time_ns() // 1000)
END
    local asks=$!
    until grep -q asks "$work/asked"; do kill -0 $asks || return; done
    killed_us=${EPOCHREALTIME/./}
    kill -KILL $run
    wait $asks
    { wait $run; } 2>/dev/null
    kill $proxy
    plant_stop
    "$hexid" identify "$work/fault.lcm" >/dev/null 2>"$work/error"
    PYTHONPATH=$work "$python" - $? "$killed_us" "$(tail -n 1 "$work/asked")" "$work/fault.lcm" <<'END'
import lcm, sys
status, killed_us, centred_us = map(int, sys.argv[1:4])
cycles = (centred_us - killed_us) / 2e3
lacks_ms = (killed_us - [event for event in lcm.EventLog(sys.argv[4], "r") if event.channel == "HEXID_STATE"][-1].timestamp) / 1e3
print(f"| daemon killed in a test | watchdog of the device | {cycles:.0f} of 15 | centred | refused: not complete; the log lacks {lacks_ms:.0f} ms |")
sys.exit(not (0 < cycles <= 15 and lacks_ms <= 100 and status == 1))
END
}
claim "the daemon killed: the device centres its valves in time, and the log is readable to the last 100 ms" tries 3 killed
sed 's/^/# /' "$work/claim.out"
