# Sourced, after tests/scenarios/lib, by what tests/uml/can runs.

# plant_start OPTION...: the plant on vcan0, ready when this returns.
plant_start() {
    "$hexid" plant --bus can:vcan0 "$@" >"$work/plant" 2>&1 &
    plant=$!
    until grep -q ready "$work/plant"; do kill -0 $plant || return 1; done
}
plant_kill() { kill -KILL $plant; }
plant_stop() {
    kill "$@" $plant
    wait $plant
} 2>/dev/null
