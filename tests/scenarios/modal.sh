#!/bin/bash
# Whole runs with gains of the modes (control.modal): the tests pass, faults are found as they are without, and a leg whose length lies or
# whose valve hangs is stopped no later, although the weights let it move the others.
. tests/scenarios/lib
. tests/scenarios/fault_lib

quick+=(--set control.modal=0.6)
clean() { "${quick[@]}" --json "$work/clean.json" >"$work/out" && ! grep -E "FAULT|warning" "$work/out"; }
claim "a whole run with gains of the modes passes its tests" clean || { cat "$work/out"; exit 1; }

# The runs are those of faults.sh, except for the weights.
some() {
    campaign <<'END'
frame loss 1 %|loss@0.5+100=1|0.5|flagged|1000
length jumps 10 mm|length@5.91+100/3=0.01|5.91|leg_rate|5
length frozen|freeze@5.91+100/3|5.91|standstill|40
lengths of legs 2 and 3 swapped|swap@5.91+100/2|5.91|following_error/leg_rate|300
not a number|nan@5.91+100/2|5.91|sensor_invalid|5
pressures of a leg lost|pressure_nan@5.91+100/3|5.91|pressure_sensor|5
supply lost: its relay opens|supply@5.91+100|5.91|supply|40
valve stuck in motion|stuck@5.91+100/3|5.91|following_error|150
valve closed|valve@5.91+100/3=0|5.91|standstill|700
valve open by 0.3|valve@5.91+100/3=0.3|5.91|following_error|150
END
}
if [ -n "${MORE_CASES:-}" ]; then # make test-long
    claim "faults with gains of the modes: detected in time, never identified wrongly in silence" some
    exit
fi
claim "control.modal is not changed while the daemon runs, and where it is changed is said" \
    refuses 2 "control.modal next start" "$hexid" command set control.modal=0.5
