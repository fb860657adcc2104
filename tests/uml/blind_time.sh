# Run by tests/uml/run: vcan0 is up and has no other user. The machine's motion without a daemon against the bound of blind_time().
. tests/scenarios/lib
. tests/scenarios/bus_lib
settings=("${quick_settings[@]}" --set motion.automatic=true)

# dies BUS MOMENTS SEED SETTING...
dies() {
    local status limit_s
    limit_s=$("$hexid" doctor --latency 0 --set lcm.url= "${@:4}" | sed -n 's/.*blind time *\([0-9.]*\) s of.*/\1/p')
    plant_start "$1" "${settings[@]}" "${@:4}" || return
    "$python" tests/uml/blind_time.py "$hexid" "$url" "$2" "$3" "${limit_s:-0}" "${settings[@]}" "${@:4}" >"$work/moments" 2>&1
    status=$?
    cat "$work/moments"
    plant_stop && return $status
}
measured() { sed 's/^/# /' "$work/moments"; }

fair_claim "CAN: killed or stopped at 40 moments, the valves are centred within the blind time" dies can:vcan0 40 1
measured
fair_claim "Modbus: the same" dies modbus:tcp://127.0.0.1:0 40 2
measured
fair_claim "CAN, the longest watchdog that is allowed: the same" dies can:vcan0 10 3 --set device.watchdog_s=0.085
measured
fair_claim "Modbus: the same" dies modbus:tcp://127.0.0.1:0 10 4 --set device.watchdog_s=0.085
measured
