#!/bin/bash
# Commands reach one machine of this host, whatever its network is, and each side notices the other's end. operators_users.sh covers who may
# give them, tests/uml/stop_checks.py floods the sockets, tests/test_commands.c gives every command in every state.
. tests/scenarios/lib
. tests/scenarios/operators_lib

# ---- whatever the network is

lan() {
    ip link set lo up && ip link add v0 type veth peer name v1 && ip addr add 10.9.9.1/24 dev v0 && ip link set v0 up && ip link set v1 up &&
        ip route add default via 10.9.9.2
}
network_none() { :; }
network_lan() { lan; }
network_lan_with_a_route_by_lo() { lan && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo; }
network_lo_alone() { ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo; }
network_lan_goes_down() { lan; }
network_lan_is_unplugged() { lan; }
meanwhile_lan_goes_down() { ip link set v0 down; }
meanwhile_lan_is_unplugged() { ip link set v1 down; }
network_filter_of_the_unit() { lan && as=("$IP_FILTER" "$cgroup"); }

# obeyed NETWORK OPTION...: all claims in this network.
obeyed() {
    local operator
    network_"$1" || return
    daemon "$1" "${@:2}" || return
    ! declare -F meanwhile_"$1" >/dev/null || meanwhile_"$1" || return
    ends 0 "$hexid" command stop && ends 0 "$hexid" command park || return
    "$hexid" command engage >"$work/$1.engage" 2>&1 &
    operator=$!
    comes ready "$1" && ends 0 "$hexid" command stop && ends 0 "$hexid" command park && comes settled "$1" 2 && ends 0 wait $operator &&
        cat "$work/$1.engage" && grep -q 'now settled' "$work/$1.engage" && ended_by TERM 0
}
if [ "${1:-}" = --in ]; then
    shift
    cd "$(dirname "$0")/../.." && obeyed "$@"
    exit
fi
namespace=
for one in "unshare -n" "unshare -Urn"; do $one true 2>/dev/null && { namespace=$one; break; }; done
networks=(none lan lan_with_a_route_by_lo lo_alone lan_goes_down lan_is_unplugged)
filter="under the unit's filter of addresses: stop, park and engage are obeyed and answered"
cgroup=$(findmnt -n -o TARGET -t cgroup2 2>/dev/null | head -n 1)/hexid.$$
export cgroup
trap 'rmdir "$cgroup" 2>/dev/null; rm -rf "$work"' EXIT
gcc -O1 -D_GNU_SOURCE -o "$work/ip_filter" tests/scenarios/ip_filter.c
if [ "$namespace" = "unshare -n" ] && "$work/ip_filter" "$cgroup" true 2>"$work/no_filter"; then networks+=(filter_of_the_unit); fi
rmdir "$cgroup" 2>/dev/null
declare -A try
for network in "${networks[@]}"; do
    [ -n "$namespace" ] || break
    IP_FILTER=$work/ip_filter $namespace "$0" --in "$network" >"$work/$network.said" 2>&1 &
    try[$network]=$!
done
for network in "${!try[@]}"; do
    wait "${try[$network]}"
    echo $? >"$work/$network.status"
done
same() { cat "$work/$1.said"; [ "$(cat "$work/$1.status")" -eq 0 ]; }
for network in "${networks[@]}"; do
    text="network ${network//_/ }: stop, park and engage are obeyed and answered"
    [ "$network" != filter_of_the_unit ] || text=$filter
    if [ -n "$namespace" ]; then claim "$text" same "$network"; else echo "ok - $text # SKIP this machine allows no network namespace"; fi
done
[[ " ${networks[*]} " == *" filter_of_the_unit "* ]] || echo "ok - $filter # SKIP no cgroup with a filter can be made here: $(head -c 200 "$work/no_filter" 2>/dev/null | tr '\n' ' ')"
claim "without LCM: the same" obeyed none --set lcm.url=

# ---- two on one host

lists() { refuses 2 "hexid-2 --machine nothing" "$hexid" command "$1"; }
two() {
    local one other
    daemon one --set lcm.url= && one=$daemon && daemon other --set lcm.url= && other=$daemon || return
    grep 'this one is `hexid-2`' "$work/other" && lists engage && lists start && lists reset &&
        ! grep -E 'engaging|pressurising' "$work/one" "$work/other" || return
    "$hexid" command engage --machine hexid-2 >"$work/operator" 2>&1 &
    local operator=$!
    comes ready other && ! grep pressurising "$work/one" && ends 0 "$hexid" command stop >"$work/both" && cat "$work/both" &&
        grep -q '^hexid: hexid: stop done' "$work/both" && grep -q '^hexid: hexid-2: stop done' "$work/both" &&
        ends 0 "$hexid" command park --set machine.name=hexid >"$work/own" && sleep 0.2 && ! grep parking "$work/other" &&
        ends 0 "$hexid" command park >"$work/both" && comes settled other 2 && ends 0 wait $operator || return
    refuses 4 "machine.name hexid-2 another" "$hexid" run --rt off "${fair[@]}" --set lcm.url= --set machine.name=hexid-2 || return
    refuses 3 "nobody nothing hexid-2 $HEXID_RUNTIME_DIR goes emergency" "$hexid" command park --machine bench --set lcm.url= || return
    kill -TERM $one && wait $one && lists_no_more && ended_by TERM 0
}
# A stop by a name that no machine has is not sent over LCM either, because another machine may share the bus with the intended one.
nobodys_name() {
    daemon named --set lcm.url= || return
    "$hexid" command engage >"$work/operator" 2>&1 &
    local operator=$!
    comes ready named && refuses 3 "nobody hexd nothing hexid (" "$hexid" command stop --machine hexd &&
        echo "machine: {name: hexd}" >"$work/named.yaml" && refuses 3 "nobody hexd machine.name=" "$hexid" command stop -c "$work/named.yaml" &&
        ends 0 "$hexid" command stop -c "$work/named.yaml" --set machine.name= >"$work/still" &&
        cat "$work/still" && grep -q 'now ready' "$work/still" && ended_by TERM 0 && ends 0 wait $operator
}
lists_no_more() { ends 4 "$hexid" command start 2>"$work/why" && cat "$work/why"; }
claim "two on one host: none moves by a command without a name, each gets its own, a stop without a name stops both" two
claim "a stop by a name that nobody has stops nothing, and names those that run" nobodys_name
claim "a name that is no name is refused" refuses 2 "machine.name A-Z" quick --set machine.name=a/b
claim "and on the command line" refuses 2 "--machine A-Z" "$hexid" command engage --machine ../x

# ---- who goes away

# The client gives up while the daemon is held up: its request must not take effect afterwards.
late() {
    daemon late --set lcm.url= || return
    for _ in 1 2; do
        kill -STOP $daemon
        ends 3 "$hexid" command engage 2>"$work/gave_up"
        local status=$?
        kill -CONT $daemon
        cat "$work/gave_up"
        ((status == 0)) && grep -q 'did not answer.*nothing has begun' "$work/gave_up" || return
        ends 0 "$hexid" command stop || return # the daemon has handled the other request by then
    done
    ! grep -E 'pressurising|engaging' "$work/late" && ended_by TERM 0
}
claim "a client that gave up sees nothing rise afterwards" late

orderly() {
    daemon orderly --set lcm.url= || return
    "$hexid" command engage >"$work/operator" 2>&1 &
    local operator=$!
    comes ready orderly && ended_by TERM 0 && ends 0 wait $operator
    local status=$?
    cat "$work/operator"
    ((status == 0)) && ! grep -i 'emergency' "$work/operator" && grep -q 'settled' "$work/operator"
}
claim "an orderly end is no alarm: parked and ended, status 0" orderly

killed() {
    daemon killed --set lcm.url= || return
    "$hexid" command engage >"$work/operator" 2>&1 &
    local operator=$!
    comes ready killed && ended_by KILL 137 2>/dev/null && ends 3 wait $operator
    local status=$?
    cat "$work/operator"
    ((status == 0)) && grep -q 'ended without a word.*STILL MOVE.*emergency stop' "$work/operator" &&
        refuses 3 "nobody" "$hexid" command park --set lcm.url= && daemon again --set lcm.url= && ! grep 'this one is' "$work/again" && ended_by TERM 0
}
claim "a daemon that is killed is an alarm at once, and what it left behind is no obstacle to the next" killed

broken() {
    daemon broken --set lcm.url= || return
    echo 'no: such: configuration' >"$work/broken.yaml"
    ends 2 "$hexid" command engage -c "$work/broken.yaml" 2>/dev/null && ends 0 "$hexid" command stop -c "$work/broken.yaml" 2>&1 && ended_by TERM 0
}
claim "a configuration that cannot be read keeps no stop from going" broken

# ---- nothing delays a stop, and a stop that cannot arrive is reported

# The caller's limits are too low for all other subcommands.
limited() {
    local limit
    daemon limited --set lcm.url= || return
    for limit in "-s 512" "-s 64" "-n 16"; do
        ends 0 bash -c "ulimit -c 0; ulimit $limit; exec \"\$@\"" _ "$hexid" command stop || return
    done
    ended_by TERM 0
}
built_with 'asan|tsan' || claim "with 64 kB of stack or 16 open files at most a stop is obeyed and answered" limited

# One of two machines cannot be told to stop: the other one is stopped, and the exit status reports the failure.
untold() {
    daemon told --set lcm.url= || return
    "$python" -c 'import signal, socket, sys; s = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM); s.bind(sys.argv[1]); s.listen()
print("listens", flush=True); signal.pause()' "$HEXID_RUNTIME_DIR/other.stop" >"$work/listens" &
    local other=$! status
    until [ -s "$work/listens" ]; do kill -0 $other || return; sleep 0.05; done
    ends 3 "$hexid" command stop --set lcm.url= >"$work/stop" 2>&1
    status=$?
    kill $other
    rm -f "$HEXID_RUNTIME_DIR/other.stop"
    cat "$work/stop"
    ((status == 0)) && grep -q '^hexid: stop done' "$work/stop" && grep -q 'not told to stop.*other.stop.*emergency stop there' "$work/stop" && ended_by TERM 0
}
claim "a stop that could not be said to one of two ends with 3 and sends to the emergency stop there" untold

# With nohup, the end of the terminal does not end the lease. Then TERM parks the platform.
hung_up() {
    daemon nohup --set lcm.url= || return
    nohup "$hexid" command engage >"$work/operator" 2>&1 &
    local operator=$!
    comes ready nohup && (((0x$(sed -n 's/^SigIgn:\s*//p' "/proc/$operator/status") & 1)) || { echo "SIGHUP is not ignored"; false; }) && kill -HUP $operator && ends 0 "$hexid" command stop && kill -TERM $operator && comes settled nohup 2 && ends 1 wait $operator || return
    cat "$work/operator"
    grep -q 'interrupted: park done' "$work/operator" && ended_by TERM 0
}
claim "\`nohup hexid command engage\` outlives its terminal, and SIGTERM still parks" hung_up

# RLIMIT_NOFILE is lowered from outside: below the number of places, where poll(2) refuses them, and below the descriptors in use.
lowered() {
    local ticks more
    daemon lowered --set lcm.url= || return
    prlimit --pid $daemon --nofile=30:1024 && ticks=$(cut -d' ' -f14 /proc/$daemon/stat) && sleep 1 &&
        more=$(($(cut -d' ' -f14 /proc/$daemon/stat) - ticks)) && echo "$more ticks of a second's 100" && ((more < 60)) &&
        ends 0 "$hexid" command stop && prlimit --pid $daemon --nofile=3:1024 || return
    "$hexid" command stop >"$work/unheard" 2>&1 &
    comes 'not even for a stop.*kill.*prlimit --pid' lowered && prlimit --pid $daemon --nofile=1024 && comes 'accepted again' lowered &&
        wait $! && ended_by TERM 0
}
claim "a limit of open files that is lowered while the daemon runs costs no stop as long as it may open one, and is said otherwise" lowered

# The sockets' directory is deleted, or another program takes the place, while the daemon runs; confined as ever.
deleted() {
    daemon deleted "$@" || return
    mv "$HEXID_RUNTIME_DIR" "$work/aside"
    comes 'hexid.stop was deleted.*not even for a stop.*emergency.*kill' deleted || return
    mv "$work/aside" "$HEXID_RUNTIME_DIR"
    comes 'is there again' deleted && ends 0 "$hexid" command stop && rm "$HEXID_RUNTIME_DIR/hexid" &&
        comes 'engage, start and reset no longer arrive' deleted && ends 0 "$hexid" command stop && rm -r "$HEXID_RUNTIME_DIR" &&
        comes 'not even for a stop' deleted 2 && ended_by TERM 0
    local status=$?
    mkdir -p -m 1777 "$HEXID_RUNTIME_DIR"
    return $status
}
claim "sockets that are deleted while the daemon runs are missed within seconds, with what still stops it" deleted --set lcm.url=
