# Run by tests/uml/run: vcan0 and vcan1 are up and have no other users.
. tests/scenarios/lib
stall_priorities=99 # on this kernel, starting a process delays the ordinary ones
. tests/scenarios/bus_lib
. tests/uml/can_lib.sh

quick_bus=("${quick_settings[@]}" "${bus_gains[@]}" --set sensors.enabled=false --set motion.automatic=true)
run_can() { "$hexid" run --hal can:vcan0 "${quick_bus[@]}" "$@"; }

quick "${bus_gains[@]}" --set sensors.enabled=false --json "$work/sim.json" >/dev/null 2>&1
# Limits: the sensors' contribution. Measured: 0.1, 0.1 and 0.7; on a busy machine 0.5, 0.7 and 1.1.
like_simulation() { as_in_simulation "$1" 0.7 1.2 4; }

identified() {
    local status
    plant_start can:vcan0 "${quick_bus[@]}" && dump || return
    ends 0 run_can --log "$work/can.lcm" --json "$work/can.json"
    status=$?
    dump_stop
    plant_stop && ((status == 0)) && like_simulation "$work/can.json"
}

decoded() {
    "$hexid" export "$work/can.lcm" -o "$work/csv" && grep -v 7FF# "$work/dump" >"$work/frames" &&
        "$python" tests/peers/can_decode.py "$work/frames" "$work/csv"
}

# during PATTERN COMMAND...: runs the command as soon as the run prints a line that matches. Exit status: the run's, 99 if there was no such
# line or the plant did not end well.
mkfifo "$work/lines"
axes=()
during() {
    local pattern=$1 run status line met=
    shift
    plant_start can:vcan0 "${quick_bus[@]}" || return
    "$hexid" run --hal can:vcan0 "${quick_bus[@]}" "${axes[@]}" --log "$work/broken.lcm" --json "$work/broken.json" >"$work/lines" 2>&1 &
    run=$!
    while read -r line; do
        echo "$line"
        [[ ! $met && $line =~ $pattern ]] || continue
        met=yes
        "$@" || { echo "cannot: $*"; met=no; }
    done <"$work/lines"
    wait $run
    status=$?
    echo "exit status $status"
    [ "$met" ] || { echo "the run ended before '$pattern'"; status=99; }
    [ "$met" != no ] || status=99
    plant_stop || status=99
    return $status
}
faults() {
    local axes=(--tests x,y)
    during "$@" >"$work/faults"
    local status=$?
    cat "$work/faults"
    [[ $status == [134] ]] && grep -qi fault "$work/faults"
}
log_is_whole() { "$hexid" export "$work/broken.lcm" -o "$work/broken$RANDOM"; }

killed_daemon() {
    local run cycles status
    plant_start can:vcan0 "${quick_bus[@]}" && dump ,080:7f8,200:7f8,580:7f8,7ff:7ff || return
    : >"$work/run"
    "$hexid" run --hal can:vcan0 "${quick_bus[@]}" >"$work/run" 2>&1 &
    run=$!
    until_in 'test 1/6' "$work/run" $run || { echo "the run ended before it was killed"; cat "$work/run"; }
    kill -KILL $run
    wait $run
    [ $? -eq 137 ] && cycles=$(emergencies)
    status=$?
    echo "valves centred ${cycles:-no} cycles after the last command"
    cansend vcan0 607#4000620100000000 # SAFETY: the relay's value
    until_in ' 587#4F00620100' "$work/dump" $plant || { echo "the supply output is not off"; status=1; }
    dump_stop
    plant_stop && return $status
}

# Frames lost and doubled on the wire itself, if the kernel permits (a vcan that echoes, netem).
# Only the nodes' readings: a master's frame that comes twice counts as another master's.
readings_twice() {
    tc -batch - <<<"qdisc add dev vcan0 root handle 1: prio
qdisc add dev vcan0 parent 1:3 netem duplicate 20%
filter add dev vcan0 parent 1: protocol can basic match canid(sff 0x180:0x780) flowid 1:3"
}
unharmed() {
    local status
    during 'test 1/6' readings_twice
    status=$?
    tc qdisc del dev vcan0 root
    ((status == 0)) && like_simulation "$work/broken.json"
}
doubled() {
    if grep -qs Y /sys/module/vcan/parameters/echo; then
        still_ms=1 fair_claim "readings doubled on the wire: identification unharmed" unharmed
    fi
}
if [ -n "${MORE_CASES:-}" ]; then # make test-long
    doubled
    exit
fi

claim "a missing interface: refused, naming it" refuses 3 "can9 interface" "$hexid" run "${bus_gains[@]}" --hal can:can9
claim "an interface that is no CAN: refused, naming it" refuses 3 "can:lo not a CAN interface" "$hexid" run "${bus_gains[@]}" --hal can:lo
ip link set vcan1 down
claim "an interface that is down: refused, naming it and the remedy" refuses 3 "can:vcan1 ip link set vcan1 up" "$hexid" run "${bus_gains[@]}" --hal can:vcan1
claim "the same for the plant" refuses 3 "can:vcan1 ip link set vcan1 up" "$hexid" plant --bus can:vcan1
ip link set vcan1 up
claim "no permission for CAN sockets: refused, naming the interface and the remedy" refuses 3 "can:vcan1 permission root AF_CAN" \
    "$python" tests/peers/no_can.py "$hexid" run "${bus_gains[@]}" --hal can:vcan1
claim "a bus without nodes: refused, naming them" refuses 3 "can:vcan1 all nodes lost" "$hexid" run "${bus_gains[@]}" --hal can:vcan1
claim "a bus too slow for the cycle: refused with the arithmetic" refuses 2 "1225 bits can.bitrate_bps" \
    "$hexid" run "${bus_gains[@]}" --hal can:vcan0 --set can.bitrate_bps=250e3

# peer SCRIPT NODE: prints its own claims.
peer() {
    local status
    plant_start can:vcan0 "${quick_bus[@]}" --set device.watchdog_s=10 || return # so that the nodes' own watchdogs are seen
    "$python" "tests/peers/$1" vcan0 "$2" >"$work/peer" 2>&1
    status=$?
    cat "$work/peer"
    plant_stop && return $status
}
fair_claim "python canopen drives a node by the EDS: set-up, readings, motion, watchdogs" peer canopen_master.py 2
grep '^ok' "$work/peer"
fair_claim "an axis node conforms to CiA 301, clause by clause" peer canopen_conformance.py 2
grep '^ok' "$work/peer"
fair_claim "the I/O module conforms to CiA 301 and 401, clause by clause" peer canopen_conformance.py 7
grep '^ok' "$work/peer"

# The nodes differ from the configuration.
stranger() {
    plant_start can:vcan0 "${quick_bus[@]}" || return
    refuses 4 "can:vcan0 0x1018:2 0x48584944 0x1 can.product_code" run_can --set can.product_code=1
    local status=$?
    plant_stop && return $status
}
claim "nodes of another product: refused, naming object, values and key" stranger
strange_io() {
    plant_start can:vcan0 "${quick_bus[@]}" || return
    refuses 4 "can:vcan0 node 7 0x1018:2 0x4858494f 0x1 can.io_product_code" run_can --set can.io_product_code=1
    local status=$?
    plant_stop && return $status
}
claim "an I/O module of another product: the same" strange_io
# The plant's relay then stays open, so the run ends while it engages: without pressure no leg follows.
not_wired() {
    local input status unwired=()
    for input in emergency_stop enable door pressure supply; do unwired+=(--set interlocks.$input=false); done
    plant_start can:vcan0 "${quick_bus[@]}" && dump ,207:7ff,607:7ff,7ff:7ff || return
    run_can "${unwired[@]}" >"$work/run" 2>&1
    status=$?
    cat "$work/run" "$work/dump"
    dump_stop
    plant_stop && ((status == 1)) && grep -q engaging "$work/run" && ! grep -q ' [26]07#' "$work/dump"
}
fair_claim "where no input and no output is wired, six nodes are enough, and no frame goes to node 7" not_wired

still_ms=1 fair_claim "six tests through the kernel's CAN, daemon and plant two processes: passed, and method A agrees with simulation" \
    identified
claim "candump and cantools see what was logged" decoded
fair_claim "a plant killed in a test: the run ends in a fault" faults 'test 1/2' plant_kill
claim "and its log is whole" log_is_whole
fair_claim "an interface that goes down in a test: the run ends in a fault" faults 'test 1/2' ip link set vcan0 down
ip link set vcan0 up

# An adapter is unplugged and plugged in again, or its interface goes down and up: daemon (confined) and plant continue with it.
processor_ticks() { awk '{ print $14 + $15 }' "/proc/$1/stat"; }
comes_back() { # WHAT-IS-THE-MATTER COMMAND-THAT-TAKES-IT COMMAND-THAT-BRINGS-IT
    local lcm='udpm://239.255.76.67:7667?ttl=0' run operator status=0 ticks
    ip link set lo multicast on && ip route replace 224.0.0.0/4 dev lo || return
    plant_start can:vcan0 "${quick_bus[@]}" || return
    : >"$work/run"
    "$hexid" run --hal can:vcan0 "${quick_bus[@]}" --set motion.automatic=false --set lcm.commands=true --set lcm.url="$lcm" >>"$work/run" 2>&1 &
    run=$!
    until_in '^ *settled' "$work/run" $run && eval "$2" &&
        until_in "device: the interface vcan0 is $1" "$work/run" $run && until_in "can:vcan0: the interface vcan0 is $1" "$work/plant" $plant
    status=$?
    ticks=$(($(processor_ticks $plant) + $(processor_ticks $run)))
    pause 1
    ticks=$(($(processor_ticks $plant) + $(processor_ticks $run) - ticks))
    ((ticks < 30)) || { echo "$ticks ticks of processor time in a second"; status=1; }
    eval "$3"
    until_in 'ready again' "$work/plant" $plant && until_in 'device: nothing is wrong' "$work/run" $run || status=1
    cat "$work/run"
    : >"$work/run"
    "$hexid" command reset --set lcm.url="$lcm"
    until_in '^ *settled' "$work/run" $run || status=1
    "$hexid" command engage --set lcm.url="$lcm" & # the client stays, so that its lease is renewed
    operator=$!
    until_in '^ *ready' "$work/run" $run || status=1
    kill -TERM $run
    wait $operator
    wait $run || status=1
    cat "$work/run" "$work/plant"
    plant_stop && return $status
}
claim "an interface that is deleted and made again: said, nobody spins, and reset and engage go on with the new one" \
    comes_back gone 'ip link del vcan0' 'ip link add dev vcan0 type vcan && ip link set vcan0 up'
claim "one that goes down and up again: the same" comes_back down 'ip link set vcan0 down' 'ip link set vcan0 up'
fair_claim "a node that is reset in a test: the run ends in a fault" faults 'test 1/2' cansend vcan0 000#8103

# A host that stalls for 40 ms: behind hardware the machine misses the deadline as well, and its watchdog centres the valves meanwhile.
stall() { kill -STOP $run; pause 0.04; kill -CONT $run; }
stalled() {
    local status
    dump ,080:7f8,7ff:7ff || return
    faults 'test 1/2' stall && grep -Eq 'FAULT (overrun|sensor_age|io)' "$work/faults" &&
        [ "$(grep -c ' 08[1-6]#5082' "$work/dump")" -ge 6 ]
    status=$?
    dump_stop
    return $status
}
fair_claim "a daemon that stalls for 40 ms in a test: a fault, and before it the nodes have centred their valves" stalled

# Interlocks.
opened() { # FAULT NAME
    local status
    plant_start can:vcan0 "${quick_bus[@]}" || return
    "$hexid" run --hal "fault:$1@3+100;can:vcan0" "${quick_bus[@]}" >"$work/faults" 2>&1
    status=$?
    cat "$work/faults"
    plant_stop && ((status == 1)) && grep -q "FAULT $2" "$work/faults"
}
fair_claim "an emergency stop in a test: a fault" opened emergency_stop emergency_stop
fair_claim "a door that opens in a test: a fault" opened door door
fair_claim "a charge pump that does not get through: the machine has no pressure, a fault" opened supply supply

# Another maker's I/O module: the plant's own is on another bus and its frames are not forwarded. Those to it are, so that the machine has
# its supply.
other_io() {
    local io run status said
    plant_start can:vcan1 "${quick_bus[@]}" && cangw -A -s vcan0 -d vcan1 -e && cangw -A -s vcan1 -d vcan0 -e -f 007~07F || return
    : >"$work/io"
    "$python" tests/peers/canopen_io.py vcan0 >"$work/io" 2>&1 &
    io=$!
    until_in ready "$work/io" $io || { cat "$work/io"; return 1; }
    : >"$work/run"
    "$hexid" run --hal can:vcan0 "${quick_bus[@]}" >"$work/run" 2>&1 &
    run=$!
    until_in 'test 1/6' "$work/run" $run && kill -USR1 $io
    wait $run
    said=$?
    kill $io
    wait $io
    status=$?
    cat "$work/run" "$work/io"
    cangw -F
    plant_stop && ((status == 0 && said == 1)) && grep -q 'FAULT emergency_stop' "$work/run"
}
if cangw -F >/dev/null 2>&1; then
    fair_claim "python canopen as the I/O module opens the emergency stop: within two cycles the valves are centred and the supply is off" \
        other_io
fi

# Another master. A second hexid sees the first and sends nothing: the first one's figures are as without it.
second() { refuses 4 "can:vcan0 another master heard" as_from_elsewhere "$hexid" run --hal can:vcan0 "${quick_bus[@]}"; }
alone() { during 'test 1/6' second && like_simulation "$work/broken.json"; }
still_ms=1 fair_claim "a second hexid does not start, and the first one's tests pass as without it" alone
second_master() { faults "test 1/" cansend vcan0 "$1" && grep -q 'FAULT second_master' "$work/faults"; }
# One of its frames here, all of them in make test-long (can_full.sh), as for what is lost on the wire.
fair_claim "a frame of another master, 201#000000000000: a fault" second_master 201#000000000000

[ "$CLOCK" = virtual ] || doubled # make test-rt
fair_claim "a daemon killed in a test: seven emergencies, valves at the centre, supply output off" killed_daemon
