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
    refuses 3 "nobody bench emergency" "$hexid" command park --machine bench --set lcm.url= || return
    kill -TERM $one && wait $one && lists_no_more && ended_by TERM 0
}
lists_no_more() { ends 4 "$hexid" command start 2>"$work/why" && cat "$work/why"; }
claim "two on one host: none moves by a command without a name, each gets its own, a stop without a name stops both" two
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
        ends 0 "$hexid" command stop || return # by now it has seen the other one
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
