# Run by tests/uml/run: vcan0 is up and has no other user. Whole runs, and the fault campaign on the bus.
. tests/scenarios/lib
stall_priorities=99 # on this kernel, starting a process delays the ordinary ones
. tests/scenarios/bus_lib
. tests/scenarios/campaign_lib
. tests/uml/can_lib.sh

# The whole run, and method A's errors beside those with sim:. Effect of stalls beyond the omitted samples: 2 ms, 12 samples of 2500, moved
# that test's axis by 0.1 points, once by 0.3; 8 ms, 23 samples, by 0.6, which the verdict refused.
exact=(--set lcm.url= --set sensors.enabled=false)
full() { # measured: 0.03, 0.04 and 0.2
    run_against can:vcan0 "${exact[@]}" && as_in_simulation "$work/run.json" 0.15 0.15 0.4
}

bus_start() { plant_start can:vcan0 "$@"; }
bus_stop() {
    tc qdisc del dev vcan0 root 2>/dev/null
    ip link set vcan0 up
    plant_stop
}

# Faults of the bus. Starting tc, ip or cansend takes this kernel 20 to 140 ms; the fault begins at their end at the latest.
befall() { from=@${EPOCHREALTIME/./}; $1; }
tool() { "$@"; tool_us=$((${EPOCHREALTIME/./} - ${from#@})); }
wire() { tool tc qdisc add dev vcan0 root netem "$@"; }
twice() { # only frames with these identifiers
    tool tc -batch - <<<"qdisc add dev vcan0 root handle 1: prio
qdisc add dev vcan0 parent 1:3 netem duplicate 20%
filter add dev vcan0 parent 1: protocol can basic match canid(sff 0x$1) flowid 1:3"
}
second() { "$hexid" run --hal can:vcan0 "${settings[@]}" 2>/dev/null; [ $? -eq 4 ] || echo "silently wrong: a second master runs"; }
silence() { # only frames with this identifier
    tool tc -batch - <<<"qdisc add dev vcan0 root handle 1: prio
qdisc add dev vcan0 parent 1:3 netem loss 100%
filter add dev vcan0 parent 1: protocol can basic match canid(sff 0x$1) flowid 1:3"
}
frame() { tool cansend vcan0 "$1"; }
down() { tool ip link set vcan0 down; }
reboot() { plant_kill; plant_start can:vcan0 "${settings[@]}"; }
stop_daemon() { kill -STOP $run; sleep 1; kill -CONT $run; }
stop_plant() { kill -STOP $plant; }

# The device's watchdog and the log after a kill, observed on the bus.
killed() {
    local killed_us cycles
    dump || return
    begun || { dump_stop; return 1; }
    kill -KILL $run
    killed_us=${EPOCHREALTIME/./}
    wait $run
    cycles=$(emergencies) || echo "$cycles"
    dump_stop
    bus_stop && after_kill "EMCY 0x8250 of 7 nodes" "$cycles" "$killed_us"
}

"$hexid" run --hal sim: --fast "${exact[@]}" --json "$work/sim.json" >/dev/null
still_ms=1 fair_claim "the six tests as shipped pass over CAN, and method A has the errors that it has with sim:" full
sed 's/^/# /' "$work/claim.out"
campaign can <<'END'
frame loss 1 %|wire loss 1%|flagged|275
frame loss 10 %|wire loss 10%|flagged|35
frame loss 100 %|wire loss 100%|sensor_age/io|15
delay 5 ms|wire delay 5ms|flagged|15
readings twice 20 %|twice 180:0x780|nothing/flagged|0
commands twice 20 %|twice 200:0x780|second_master|35
reordering|wire delay 1ms reorder 50% 50%|flagged|15
bit flips in 10 % of the frames|wire corrupt 10%|flagged|35
bus-off reported|frame 20000040#0000000000000000|flagged/sensor_invalid|15
error-passive reported|frame 20000004#0020000000000000|nothing/flagged/verdict|0
node 3 reset by another master|frame 000#8103|second_master|15
SYNC of another master|frame 080#|second_master|15
command of another master|frame 204#000000000000|second_master|15
SDO of another master|frame 603#4000100000000000|second_master|15
outputs of another master|frame 207#01|second_master|15
heartbeat of another master|frame 77F#05|second_master|15
NMT of another master|frame 000#0105|second_master|15
another hexid started|second|nothing|0
EMCY of node 3|frame 083#0050810000000000|sensor_invalid|15
plant stopped|stop_plant|sensor_age|15
plant rebooted in a test|reboot|emergency_stop/sensor_age/sensor_invalid/io|15
daemon stopped for 1 s|stop_daemon|overrun/sensor_age/io|10
interface down|down|io|15
daemon's heartbeat lost|silence 77F|sensor_invalid/io|95
heartbeat of node 3 lost, its readings go on|silence 703|nothing/flagged|0
readings of node 3 lost|silence 183|sensor_age|25
commands of legs 1 to 3 lost|silence 201|sensor_invalid/io|30
SYNC lost|silence 080|sensor_age/io|25
bus at 20 kbit/s|wire rate 20kbit|sensor_age/io|25
transmit queue of 4 frames, full|wire delay 5ms limit 4|sensor_age/io|25
END
fair_claim "the daemon killed: the nodes centre their valves in time, and the log is readable to the last 100 ms" killed
row
