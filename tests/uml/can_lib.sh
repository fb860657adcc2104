# Sourced, after tests/scenarios/bus_lib, by the scripts that tests/uml/run runs.

# dump [,ID:MASK...]: writes the bus's frames, all or these (7ff among them), to $work/dump until dump_stop.
dump() {
    : >"$work/dump" # otherwise the previous dump would be taken for this one
    stdbuf -oL candump -L -r 16777216 "vcan0${1:-}" >"$work/dump" & # 13 500 frames per second, and candump is the least urgent process
    dumper=$!
    until [ -s "$work/dump" ]; do kill -0 $dumper && cansend vcan0 7ff# || return; done # candump is listening once it has seen this
}
dump_stop() {
    kill $dumper
    wait $dumper
}

# Waits for EMCY 0x8250 from the watchdogs of all seven nodes; returns the cycles from the last command to the last of them.
emergencies() {
    local node
    for node in 1 2 3 4 5 6 7; do
        until_in " 08$node#5082" "$work/dump" $plant || { echo "node $node sent no EMCY 0x8250"; return 1; }
    done
    awk '{ at = substr($1, 2, length($1) - 2) } / 20[147]#/ { command = at } / 08[1-7]#5082/ { centred = at; n++ }
        END { print (centred - command) / 2e-3; exit n != 7 }' "$work/dump"
}
