# Run by tests/uml/run. The fault campaign on Modbus TCP.
. tests/scenarios/lib
. tests/scenarios/bus_lib
. tests/scenarios/campaign_lib
ahead=$(chrt -f 70 true 2>/dev/null && echo chrt -f 70)

# The plant behind a proxy, which takes orders.
mkfifo "$work/orders"
bus_start() {
    plant_start modbus:tcp://127.0.0.1:0 "$@" || return
    plant_url=$url
    : >"$work/proxy"
    exec 5<&-
    exec 5<>"$work/orders" # open at both ends, so that nobody waits for or dies of a closed one
    $ahead "$python" tests/peers/modbus_proxy.py "${plant_url##*:}" <"$work/orders" >"$work/proxy" &
    proxy=$!
    until_in '^[0-9]' "$work/proxy" $proxy || { kill $proxy; wait $proxy; plant_stop; return 1; }
    url=modbus:tcp://127.0.0.1:$(<"$work/proxy")
}
bus_stop() {
    local status
    kill $proxy
    wait $proxy
    status=$?
    ((status == 143)) || echo "the proxy ended before it was told to"
    plant_stop && ((status == 143))
}

# Faults of the line: a function here, or an order to the proxy, which then reports the time.
befall() {
    from=@${EPOCHREALTIME/./}
    if declare -F "$1" >/dev/null; then $1; else order "$1"; fi
}
order() {
    echo "$1" >&5
    until_in '^[0-9]{16}' "$work/proxy" $proxy && from=@$(tail -n 1 "$work/proxy")
}
stop_daemon() { kill -STOP $run; sleep 1; kill -CONT $run; }
stop_plant() { kill -STOP $plant; }
restart() { plant_kill; plant_start "$plant_url" "${settings[@]}"; }

# The device's watchdog and the log after a kill: the plant itself, not the proxy, is asked when its valves are centred.
killed() {
    local asks killed_us
    begun || return
    : >"$work/asked"
    "$python" - "${plant_url##*:}" >"$work/asked" <<'END' &
import socket, struct, sys, time
plant = socket.create_connection(("127.0.0.1", int(sys.argv[1])))
centred, end = None, time.monotonic() + 60
while not centred and time.monotonic() < end:
    plant.sendall(b"\0\1\0\0\0\6\1\3\0\x21\0\1")  # MODBUS_STATUS
    if centred is None:
        print("asks", flush=True)
    centred = plant.recv(260)[10] & 1
print(time.time_ns() // 1000)
END
    asks=$!
    until_in asks "$work/asked" $asks
    killed_us=${EPOCHREALTIME/./}
    kill -KILL $run
    wait $run
    [ $? -eq 137 ] || echo "the run ended before it was killed"
    wait $asks
    bus_stop && after_kill "watchdog of the device, after the kill" $((($(tail -n 1 "$work/asked") - killed_us) / 2000)) "$killed_us"
}

clean() { run_against modbus:tcp://127.0.0.1:0 "${quick_settings[@]}"; }
fair_claim "a run without a fault passes" clean
campaign Modbus <<'END'
answers lost 1 %|loss 1|flagged|900
answers lost 10 %|loss 10|flagged|90
answers lost 100 %|loss 100|sensor_age/io|25
answers delayed 3 ms|delay 3|flagged|10
answers delayed 20 ms|delay 20|sensor_age/io|25
answers twice 20 %|twice 20|nothing/flagged|0
bit flips in 10 % of the answers|flip 10|flagged/leg_rate/stroke/sensor_invalid/force/following_error/second_master|0
wrong transaction numbers|number|sensor_age/io|25
exceptions|exception|sensor_age/io|25
half answers|half|sensor_age/io|25
connection reset|reset|io|40
server hangs|hang|sensor_age/io|40
server stopped|stop_plant|sensor_age/io|25
server restarted|restart|sensor_age/io|25
daemon stopped for 1 s|stop_daemon|overrun/sensor_age|25
END
fair_claim "the daemon killed: the device centres its valves in time, and the log is readable to the last 100 ms" killed
row
