# Run by tests/uml/can: vcan0 is up, and nobody else is on it. Whole runs, and the fault campaign on the bus; all in real time.
. tests/scenarios/lib
. tests/uml/can_lib.sh
lcm-gen -p --ppath "$work" lcmtypes/*.lcm

full() {
    "$hexid" run --hal sim: --fast --set lcm.url= --set sensors.enabled=false --json "$work/sim.json" >/dev/null
    for _ in 1 2 3; do
        plant_start --set sensors.enabled=false
        "$hexid" run --hal can:vcan0 --set lcm.url= --set motion.automatic=true --set sensors.enabled=false --json "$work/can.json" >"$work/run" 2>&1
        status=$?
        plant_stop
        cat "$work/run"
        [ $status -eq 0 ] && return
    done
    return 1
}

bus_settings=("${quick_settings[@]}" --set motion.automatic=true)

# begun SECONDS: waits until the run's log is that long on the loop's clock.
begun() {
    until PYTHONPATH=$work "$python" -c 'import hexid, lcm, sys
last = [e for e in lcm.EventLog(sys.argv[1], "r") if e.channel == "HEXID_STATE"][-1:]
sys.exit(not (last and hexid.state_t.decode(last[0].data).time_ns >= 1e9 * float(sys.argv[2])))' "$work/fault.lcm" "$1" 2>/dev/null; do
        kill -0 $run 2>/dev/null || return 1
    done
}

# What befalls the bus. Each is undone by mend(). Starting tc, ip or cansend takes this kernel up to 50 ms, 25 cycles, and counts.
wire() { tc qdisc add dev vcan0 root netem "$@"; }
frame() { cansend vcan0 "$1"; }
frames() { for _ in $(seq 20); do cansend vcan0 "$1"; done; }
reboot() { plant_kill; wait $plant; plant_start "${quick_settings[@]}"; } 2>/dev/null
stop_daemon() { kill -STOP $run; sleep 1; kill -CONT $run; }
stop_plant() { kill -STOP $plant; }
down() { ip link set vcan0 down; }
mend() {
    tc qdisc del dev vcan0 root 2>/dev/null
    ip link set vcan0 up
    kill -CONT $plant 2>/dev/null
}

# fault NAME|WHAT|EXPECTED|WITHIN: WHAT is a function above, or a fault of hal/fault.c from 3 s on (in the second test).
fault() {
    local name what expected within from=3
    IFS='|' read -r name what expected within <<<"$1"
    local hal=can:vcan0 words=($what)
    [[ $what == *@* ]] && hal="fault:$what;$hal" words=()
    plant_start "${quick_settings[@]}"
    rm -f "$work/fault.lcm" "$work/fault.json"
    "$hexid" run --hal "$hal" "${bus_settings[@]}" --log "$work/fault.lcm" --json "$work/fault.json" >"$work/fault.out" 2>&1 &
    run=$!
    if ((${#words[@]})); then
        begun 3 || { echo "$name: the run ended too early" >&2; cat "$work/fault.out" >&2; }
        from=@${EPOCHREALTIME/./}
        "${words[@]}"
    fi
    wait $run
    local status=$?
    mend
    plant_stop
    ((status == 0 || status == 1)) || echo "$name: exit status $status" >&2
    PYTHONPATH=$work "$python" tests/scenarios/faults.py "$name" "$from" "$expected" "$within" "$work/fault.lcm" "$work/fault.json" "$work/clean.json"
}

clean() {
    for _ in 1 2 3; do
        plant_start "${quick_settings[@]}"
        "$hexid" run --hal can:vcan0 "${bus_settings[@]}" --json "$work/clean.json" >"$work/run" 2>&1
        local status=$?
        plant_stop
        [ $status -eq 0 ] && return
    done
    cat "$work/run"
    return 1
}

campaign() {
    while read -r line; do fault "$line" 2>>"$work/bad"; done
    ! grep . "$work/bad"
}

listed() {
    campaign <<'END'
frame loss 1 %|wire loss 1%|flagged|50
frame loss 10 %|wire loss 10%|flagged/sensor_age/io|0
frame loss 100 %|wire loss 100%|sensor_age/io|40
delay 5 ms|wire delay 5ms|flagged/sensor_age|40
duplicates 20 %|wire duplicate 20%|nothing/flagged|0
reordering|wire delay 1ms reorder 50% 50%|flagged/sensor_age|0
bit flips in 10 % of the frames|wire corrupt 10%|flagged/leg_rate/stroke/sensor_age/sensor_invalid/io|0
bus-off reported|frame 20000040#0000000000000000|flagged/sensor_invalid|40
error-passive reported|frame 20000004#0020000000000000|nothing/flagged|0
node 3 reset|frame 000#8103|sensor_invalid/io|40
EMCY of node 3|frame 083#0050810000000000|sensor_invalid|40
plant stopped|stop_plant|sensor_age|15
plant rebooted in a test|reboot|sensor_age/sensor_invalid/io|15
daemon stopped for 1 s|stop_daemon|overrun/io|10
interface down|down|io|40
length frozen|freeze@3+100/3|standstill/verdict|0
not a number|nan@3+100/2|sensor_invalid|5
length out of range|length@3+100/3=1|stroke|5
length jumps 10 mm|length@3+100/3=0.01|leg_rate|5
lengths of legs 2 and 3 swapped|swap@3+100/2|following_error/leg_rate/verdict|0
pressure out of range|pressure@3+100/3=2e7|sensor_invalid|5
pressures of legs 2 and 3 swapped|mix@0.05+100/2|verdict|0
END
}

claim "the six tests as shipped pass over CAN" full
claim "method A has the errors that it has with sim:" compare "$work/sim.json" "$work/can.json" 0.15 0.4 # measured: 0.03 and 0.2
sed 's/^/# /' "$work/claim.out" "$work/run"
clean || exit 1
claim "every fault on the bus is detected in time or harmless, and never identified wrongly in silence" listed
sed 's/^/# /' "$work/claim.out"
