#!/bin/bash
# The daemon and the plant as two processes on Modbus TCP and a serial line, and another maker's programs at either end; in real time.
# Runs alone.
. tests/scenarios/lib
. tests/scenarios/modbus_lib
S=("${quick_settings[@]}" --set sensors.enabled=false)
# Sanitizers and busy machines miss deadlines: what is tested here is what is said, not how fast.
patient=(--set limits.sensor_age_s=1 --set device.watchdog_s=2 --set limits.bad_cycles=50 --set loop.overrun_limit=100000)

nobody() { # a port on which nobody listens
    "$python" -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'
}
claim "an address that is none: refused, with the right form" refuses 2 "modbus:tcp://HOST:PORT" "$hexid" run --hal modbus:tcp:localhost
claim "a host that refuses: named" refuses 3 "127.0.0.1 refused" "$hexid" run --hal "modbus:tcp://127.0.0.1:$(nobody)"
claim "a host that does not exist: named" refuses 3 "no.such.host.invalid" "$hexid" run --hal modbus:tcp://no.such.host.invalid:502
claim "a serial device that is missing: named" refuses 3 "/dev/ttyNONE serial device" "$hexid" run --hal 'modbus:rtu:/dev/ttyNONE?baud=4000000'
claim "a file that is no serial device: named" refuses 3 "/dev/null" "$hexid" run --hal 'modbus:rtu:/dev/null?baud=4000000'
claim "a line too slow for the cycle: refused with the arithmetic" refuses 2 "27 59 8.1 115200 loop.period_s" "$hexid" run --hal 'modbus:rtu:/dev/null?baud=115200'
claim "the map is printed" eval '"$hexid" doctor --modbus-map | grep -q "0x0022..0x002d"'

plant_start tcp://127.0.0.1:0 "${S[@]}"
"$python" tests/peers/modbus_client.py "${url##*:}"
plant_stop

foreign() { # another maker's device: the daemon reads it, and sees that it does not move
    "$python" tests/peers/modbus_server.py >"$work/port" &
    local server=$! port
    until read -r port <"$work/port"; do kill -0 $server || return 1; done 2>/dev/null
    "$hexid" run --rt off --hal "modbus:tcp://127.0.0.1:$port" --set lcm.url= --set motion.automatic=true "${patient[@]}" >"$work/run" 2>&1
    local status=$?
    kill $server
    cat "$work/run"
    [ $status -eq 1 ] && grep -q settled "$work/run" && grep -q standstill "$work/run"
}
claim "a pymodbus server in the plant's place: read, and found to stand still" foreign

case ${BUILD:-build} in
*san) echo "ok - six tests over Modbus TCP # SKIP real time at a tenth of the speed" ;;
*)
    # Three tries: where the machine stops for longer than the watchdog allows, the platform rightly stops too.
    claim "six tests over Modbus TCP at 2 ms, daemon and plant two processes: passed" tries 3 run_tcp "${S[@]}"
    quick --set sensors.enabled=false --json "$work/sim.json" >/dev/null
    agrees "method A agrees with the simulation" 0.7 1.2 4 tries 3 run_tcp "${S[@]}" # what the sensors may cost; measured: 0.1, 0.1 and 0.3
    ;;
esac
