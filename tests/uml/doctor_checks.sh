# Run by tests/uml/run: vcan0 and vcan1 are up. A serial line (slcan) with a program at its other end provides a controller with bit rate
# and errors.
. tests/scenarios/lib
# The gains are those that suit a bus (tests/scenarios/bus_lib), which saves each doctor the search for better ones.
doctor() { "$hexid" doctor --latency 0 --set lcm.url= --set control.kp=49 --set control.kpf=6.2e-7 "$@" >"$work/doctor" 2>&1; local status=$?; cat "$work/doctor"; return $status; }
# finds LEVEL NAME WORDS OPTION...
finds() { doctor "${@:4}"; grep -E "^  $1 +$2 .*$3" "$work/doctor"; }

claim "a virtual CAN interface has neither bit rate nor counters" finds ok 'CAN interface' 'vcan0 is up; vcan has no controller' --hal can:vcan0
ip link set vcan1 down
claim "an interface that is down: FAIL, with the remedy" finds FAIL 'CAN interface' 'interface is down' --hal can:vcan1
claim "its exit status is 1" ends 1 doctor --hal can:vcan1
ip link set vcan1 up

mkfifo "$work/say"
"$python" tests/peers/slcan.py <"$work/say" >"$work/slcan" 2>&1 &
adapter=$!
exec 5>"$work/say"
until_in() { for _ in {1..100}; do grep -q "$1" "$2" && return; sleep 0.1; done; cat "$2"; return 1; }
until_in ready "$work/slcan" && ip link set can0 up type can bitrate 500000 || {
    echo "ok - a controller's bit rate and errors # SKIP this kernel has no slcan"
    exit
}
claim "a controller with another bit rate than configured: FAIL, with both" finds FAIL 'CAN interface' '500000 bit/s, can.bitrate_bps is 1000000' --hal can:can0
claim "with the same: ok" finds ok 'CAN interface' '500000 bit/s' --hal can:can0 --set can.bitrate_bps=500e3
claim "no errors: ok" finds ok 'CAN errors' 'error-active' --hal can:can0

# state LETTER NAME: the adapter reports this controller state, and the kernel has it.
state() {
    echo "s${1}130010" >&5
    for _ in {1..100}; do ip -details link show can0 | grep -q "state $2" && return; sleep 0.1; done
    return 1
}
passive() { state p ERROR-PASSIVE && finds WARN 'CAN errors' 'error-passive, .* 1 error-passive' --hal can:can0; }
claim "error-passive: WARN" passive
as_ip() {
    doctor --hal can:can0 --json "$work/doctor.json"
    ip -json -details -statistics link show can0 >"$work/ip.json"
    "$python" - "$work/doctor.json" "$work/ip.json" <<'END'
import json, sys
found = {f["name"]: f["data"] for f in json.load(open(sys.argv[1]))["findings"]}
info = json.load(open(sys.argv[2]))[0]["linkinfo"]
print(found["CAN interface"], found["CAN errors"], info)
own, its = found["CAN errors"], info["info_xstats"]
assert its["error_passive"] == 1 and found["CAN interface"]["bitrate_bps"] == info["info_data"]["bittiming_bitrate"] == 500000
assert own["tx_errors"] is None and own["state"].upper() == info["info_data"]["state"]
for name, of_ip in (("restarts", "restarts"), ("bus_errors", "bus_error"), ("arbitration_lost", "arbitration_lost"), ("error_warning", "error_warning"),
                    ("error_passive", "error_passive"), ("bus_off", "bus_off")):
    assert own[name] == its[of_ip], name
END
}
claim "bit rate, state and counts are those of ip -details -statistics" as_ip
off() { state b BUS-OFF && finds FAIL 'CAN errors' bus-off --hal can:can0; }
claim "bus-off: FAIL" off
exec 5>&-
wait $adapter
