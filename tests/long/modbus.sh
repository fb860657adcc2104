#!/bin/bash
# Whole runs over Modbus TCP and over a serial line, in real time: three minutes.
. tests/scenarios/lib
. tests/scenarios/modbus_lib
exact=(--set lcm.url= --set sensors.enabled=false)

"$hexid" run --fast "${exact[@]}" --json "$work/sim.json" >/dev/null
claim "the six tests as shipped pass over Modbus TCP at 2 ms" tries 3 run_tcp "${exact[@]}"
sed 's/^/# /' "$work/run"
agrees "method A within 0.15 points of sim:, coupling within 0.4" 0.15 0.15 0.4 tries 3 run_tcp "${exact[@]}" # measured: 0.02, 0.05 and 0.2

# A line of 115200 baud carries a cycle in 8.1 ms: 10 ms, and a controller that is slower by as much. The matrix is then far off, for
# the staircase of the command and not for the line: the same in simulation at 10 ms. hexid refuses it.
serial=(--set sim.engine=closed_form --set loop.period_s=0.01 --set sim.substeps=40 --set limits.sensor_age_s=0.05 --set device.watchdog_s=0.1 --set limits.following_m=0.03
    --set control.kp=20 --set control.kpf=1e-5 --set control.kff=1.8 --set motion.engage_s=5 --set motion.park_s=5)
run_serial() {
    local line plant status ends
    rm -f "$work/line"
    $ahead "$python" tests/peers/serial_line.py 115200 >"$work/line" &
    line=$!
    until [ "$(wc -l <"$work/line")" = 2 ]; do kill -0 $line || return 1; done 2>/dev/null
    mapfile -t ends <"$work/line"
    plant_start "rtu:${ends[0]}?baud=115200" "${exact[@]}" "${serial[@]}"
    "$hexid" run --hal "modbus:rtu:${ends[1]}?baud=115200" "${exact[@]}" "${serial[@]}" --set motion.automatic=true --json "$work/run.json" >"$work/run" 2>&1
    status=$?
    plant_stop
    kill $line
    cat "$work/run"
    return $status
}
ahead=$(chrt -f 70 true 2>/dev/null && echo chrt -f 70)
refused_for_its_cycle() { [ "$(grep -A9 '^verdict' "$work/run" | grep -c '^  ')" -eq 1 ] && grep -q "a cycle of 10 ms puts" "$work/run"; }
refused() {
    run_serial
    [ $? -eq 1 ] && refused_for_its_cycle
}
text="six tests over a serial line of 115200 baud at 10 ms: all good but the cycle, for which the matrix is refused"
if tries 3 refused >"$work/runs" || ! grep -q 'of the samples excluded' "$work/run"; then
    claim "$text" refused_for_its_cycle
    "$hexid" run --fast "${exact[@]}" "${serial[@]}" --json "$work/sim.json" >/dev/null
    agrees "the matrix is off by what sim: is off by at 10 ms" 0.6 0.6 1.5 tries 3 refused # measured: 0.2, 0.3 and 1
else
    echo "ok - $text # SKIP too many samples left out in each of three runs: the line of this test is a process, and late by its machine's stalls"
fi
sed 's/^/# /' "$work/run"
