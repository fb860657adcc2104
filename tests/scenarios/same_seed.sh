#!/bin/bash
# A virtual-time run is a function of its configuration and seed, to the last bit; so is the result read back from its log.
. tests/scenarios/lib

run() { quick --log "$work/$1.lcm" --json "$work/$1.json" "${@:2}"; }
same() { cmp "$work/$1.lcm" "$work/$2.lcm" && cmp "$work/$1.json" "$work/$2.json"; }
differ() { ! cmp -s "$work/$1.lcm" "$work/$2.lcm" && ! cmp -s "$work/$1.json" "$work/$2.json"; }
identify_repeats() { "$hexid" identify "$work/a.lcm" --json "$work/again.json"; cmp "$work/a.json" "$work/again.json"; }
ode() { run "$1" --set sim.engine=ode --tests z --seed 7 --set effects.cylinder_coulomb_friction.force_extend_n=50; }

claim "a quick run passes its checks" run a --seed 7
claim "the same seed gives the same log and results, byte for byte" eval 'run b --seed 7 && same a b'
claim "another seed gives another log and other results" eval 'run c --seed 8 && differ a c'
claim "identify makes of the log what the run made, byte for byte" identify_repeats
ode d >"$work/ode" 2>&1
ode e >>"$work/ode" 2>&1
claim "the same with ODE's bodies and with dry friction" same d e
