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

# compare SIM CAN POINTS COUPLING: method A's errors of two runs differ by no more than so many points of a percent.
compare() {
    "$python" - "$@" <<'END'
import json, sys
sim, can = (json.load(open(path))["errors_pct"]["method_a"] for path in sys.argv[1:3])
limit = {name: float(sys.argv[4 if name.startswith("Mt") else 3]) for name in sim}
for name in sim: print(f"{name:5} sim {sim[name]:+.2f} can {can[name]:+.2f} %")
sys.exit(not all(abs(sim[name] - can[name]) < limit[name] for name in sim))
END
}
