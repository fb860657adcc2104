# Run by tests/uml/can: vcan0 and vcan1 are up, and nobody else is on them.
. tests/scenarios/lib
. tests/uml/can_lib.sh

quick_bus=("${quick_settings[@]}" --set sensors.enabled=false --set motion.automatic=true)
run_can() { "$hexid" run --hal can:vcan0 "${quick_bus[@]}" "$@"; }

# dump FILE: what is on the bus, until dump_stop.
dump() {
    stdbuf -oL candump -L vcan0 >"$1" &
    dumper=$!
    until [ -s "$1" ]; do cansend vcan0 7ff#; done # candump listens when it has seen this
}
dump_stop() {
    kill $dumper
    wait $dumper
} 2>/dev/null

# Three tries: where the machine under this kernel stops for longer than the watchdog allows, the platform rightly stops too.
identified() {
    for _ in 1 2 3; do
        plant_start "${quick_bus[@]}"
        dump "$work/dump"
        run_can --log "$work/can.lcm" --json "$work/can.json" >"$work/run" 2>&1
        status=$?
        dump_stop
        plant_stop
        tail -n 4 "$work/run"
        [ $status -eq 0 ] && return
    done
    cat "$work/run"
    return 1
}

as_in_simulation() {
    quick --set sensors.enabled=false --json "$work/sim.json" >"$work/sim" 2>&1 || cat "$work/sim"
    compare "$work/sim.json" "$work/can.json" 0.7 1.2 4 # what the sensors may cost; measured: 0.1, 0.1 and 0.7, on a busy machine 0.5, 0.7 and 1.1
}

decoded() {
    "$hexid" export "$work/can.lcm" -o "$work/csv" && grep -v 7FF# "$work/dump" >"$work/frames" && "$python" tests/peers/can_decode.py "$work/frames" "$work/csv"
}

# during PATTERN COMMAND...: a run; the command as soon as it prints a line that matches. Its exit status must be 1: done, not passed.
during() {
    local pattern=$1 run
    shift
    plant_start "${quick_bus[@]}"
    dump "$work/dump"
    mkfifo "$work/lines"
    run_can --log "$work/broken.lcm" >"$work/lines" 2>&1 &
    run=$!
    while read -r line; do
        echo "$line"
        [[ $line =~ $pattern ]] && "$@" && pattern='no such line'
    done <"$work/lines"
    rm "$work/lines"
    wait $run
    status=$?
    dump_stop
    plant_stop
    echo "exit status $status"
}
faults() { during "$@" | tee "$work/faults" && grep -q fault "$work/faults" && grep -qx 'exit status [134]' "$work/faults"; }
log_is_whole() { "$hexid" export "$work/broken.lcm" -o "$work/broken$RANDOM"; }

killed_daemon() {
    plant_start "${quick_bus[@]}"
    dump "$work/dump"
    "$hexid" run --hal can:vcan0 "${quick_bus[@]}" >"$work/run" 2>&1 &
    local run=$!
    until grep -q 'test 1/6' "$work/run"; do kill -0 $run || break; done
    kill -KILL $run
    wait $run
    until grep -q ' 086#5082' "$work/dump"; do kill -0 $plant || break; done # EMCY 0x8250 of node 6
    dump_stop
    plant_stop
    awk '/ 20[14]#/ { last = substr($1, 2) } / 08[1-6]#5082/ { printf "valves centred %.1f ms after the last command\n", 1e3 * (substr($1, 2) - last); n++ }
         END { exit n != 6 }' "$work/dump"
} 2>/dev/null

claim "a missing interface: refused, naming it" refuses 3 "can9 interface" "$hexid" run --hal can:can9
claim "an interface that is no CAN: refused, naming it" refuses 3 "can:lo not a CAN interface" "$hexid" run --hal can:lo
ip link set vcan1 down
claim "an interface that is down: refused, naming it and the remedy" refuses 3 "can:vcan1 ip link set vcan1 up" "$hexid" run --hal can:vcan1
claim "the same for the plant" refuses 3 "can:vcan1 ip link set vcan1 up" "$hexid" plant --bus can:vcan1
ip link set vcan1 up
claim "no permission for CAN sockets: refused, naming the interface and the remedy" refuses 3 "can:vcan1 permission root AF_CAN" \
    "$python" tests/peers/no_can.py "$hexid" run --hal can:vcan1
claim "a bus without nodes: refused, naming them" refuses 3 "can:vcan1 all nodes lost" "$hexid" run --hal can:vcan1
claim "a bus too slow for the cycle: refused with the arithmetic" refuses 2 "1095 bits can.bitrate_bps" "$hexid" run --hal can:vcan0 --set can.bitrate_bps=250e3

plant_start "${quick_bus[@]}"
"$python" tests/peers/canopen_master.py vcan0 2
plant_stop

claim "six tests through the kernel's CAN, daemon and plant two processes: passed" identified
claim "method A agrees with the simulation" as_in_simulation
claim "candump and cantools see what was logged" decoded
claim "a plant killed in a test: the run ends in a fault" faults 'test 2/6' plant_kill
claim "and its log is whole" log_is_whole
claim "an interface that goes down in a test: the run ends in a fault" faults 'test 2/6' ip link set vcan0 down
ip link set vcan0 up
claim "a node that is reset in a test: the run ends in a fault" faults 'test 2/6' cansend vcan0 000#8103

# Frames lost and doubled on the wire itself, where the kernel lets us (a vcan that echoes, netem).
disturbed() {
    plant_start "${quick_bus[@]}"
    run_can --json "$work/disturbed.json" >"$work/run" 2>&1 &
    local run=$! status
    until grep -q 'test 1/6' "$work/run"; do kill -0 $run || break; done
    tc qdisc add dev vcan0 root netem $1
    wait $run
    status=$?
    tc qdisc del dev vcan0 root
    plant_stop
    cat "$work/run"
    return $status
}
unharmed() {
    for _ in 1 2 3; do disturbed "$1" && break; done
    compare "$work/sim.json" "$work/disturbed.json" 0.7 1.2 4
}
refused() {
    disturbed "$1"
    [ $? -eq 1 ] && grep -q 'verdict *fail' "$work/run"
}
if grep -qs Y /sys/module/vcan/parameters/echo; then
    claim "frames doubled on the wire: identification unharmed" unharmed "duplicate 20%"
    claim "one frame in a hundred lost: identification refused, not wrong" refused "loss 1%"
    claim "one frame in ten lost: refused" refused "loss 10%"
    claim "all frames lost: refused" refused "loss 100%"
fi
claim "a daemon killed in a test: six emergencies, valves at the centre" killed_daemon
