#!/bin/bash
# Duration of `hexid command` from start to end, process and configuration included; on a quiet machine.
. tests/scenarios/lib
. tests/scenarios/operators_lib

# took COMMAND TIMES: prints the median duration in ms of TIMES runs.
took() {
    daemon "took_$1" --set lcm.url= || return
    for _ in $(seq "$2"); do
        local begun=${EPOCHREALTIME/./}
        "$hexid" command "$1" >/dev/null || return
        echo $((${EPOCHREALTIME/./} - begun))
    done | sort -n | awk -v name="$1" '{ t[NR] = $1 / 1000 } END {
        printf "%s: median of %d %.1f ms, 95 %% %.1f ms, longest %.1f ms\n", name, NR, t[int((NR + 1) / 2)], t[int(0.95 * NR)], t[NR]
        exit !(NR && t[int((NR + 1) / 2)] <= 20) }' | tee "$work/$1.took"
    local status=${PIPESTATUS[2]}
    ended_by TERM 0 && return "$status"
}
for command in stop park; do
    claim "$command: done and answered within 20 ms, the median of 200" took $command 200
    sed 's/^/# /' "$work/$command.took"
done
# engaged: prints the time from the start of the client to its first line; each run is parked again.
engaged() {
    daemon engaged --set lcm.url= --set lcm.lease_s=1 || return # interval at which the client checks for the end
    local begun line
    for _ in $(seq "$1"); do
        begun=${EPOCHREALTIME/./}
        coproc operator { exec "$hexid" command engage; }
        local client=$operator_PID
        read -r line <&"${operator[0]}"
        echo $((${EPOCHREALTIME/./} - begun))
        [[ $line == *"engage done"* ]] && "$hexid" command park >/dev/null && wait "$client" || { echo "$line" >&2; return 1; }
    done >"$work/engages" && sort -n "$work/engages" | awk '{ t[NR] = $1 / 1000 } END {
        printf "engage: median of %d %.1f ms, longest %.1f ms\n", NR, t[int((NR + 1) / 2)], t[NR]; exit !(NR && t[int((NR + 1) / 2)] <= 20) }' |
        tee "$work/engage.took"
    local status=${PIPESTATUS[1]}
    ended_by TERM 0 && return "$status"
}
claim "engage: the same, of 200" engaged 200
sed 's/^/# /' "$work/engage.took"
