#!/bin/bash
# Hidden effects, a small fixed draw, through the programs: the rig is a run of its own (the other engine, a finer step, sensors on, the
# base's parameters off everywhere within the model's tolerance), hexid gap gets its log and the base model, this script holds the truth.
. tests/scenarios/lib

base="--set payload.mass_kg=179.9 --set payload.inertia_xx_kg_m2=13.49 --set hydraulics.bulk_modulus_pa=0.965e9
      --set hydraulics.leakage_m3_per_s_pa=3.1e-11 --set hydraulics.viscous_n_s_per_m=1930 --set hydraulics.valve_flow_m3_per_s=1.61e-3"
beyond="--set hydraulics.supply_pa=10.15e6 --set hydraulics.valve_damping=0.7 --set hydraulics.dead_volume_m3=1.2e-4"
coulomb="--set effects.cylinder_coulomb_friction.force_extend_n=50 --set effects.cylinder_coulomb_friction.force_retract_n=50"
joint="--set effects.passive_joint_friction.coulomb_nm=5"

short="--set motion.engage_s=1.6 --set motion.park_s=1.6 --set motion.hold_s=0.1 --set tests.settle_s=0.5"
rig() { "$hexid" run --fast --set lcm.url= --set sim.engine=ode --set sim.substeps=12 $short --log "$work/$1.lcm" $base "${@:2}" >/dev/null; }
gap() { "$hexid" gap --measured "$work/$1.lcm" -c config/tian2015.yaml -o "$work/$1" "${@:2}" 2>/dev/null; }
says() { "$python" tests/scenarios/gap.py "$@"; }
diagnosed() { local name=$1; shift; rig "$name" --seed 5 "${@:2}" && gap "$name" && says "$work/$name/gap.json" $1; }

claim "nothing but the tolerance: no gap" diagnosed none no_gap
claim "beyond the tolerance: still no gap" diagnosed beyond no_gap $beyond
claim "Coulomb friction is named, and the gap closes to 1.2 times the noise on held-out cycles" diagnosed coulomb cylinder_coulomb_friction $coulomb
claim "the same with a base that is off beyond its tolerance" diagnosed coulomb2 cylinder_coulomb_friction $coulomb $beyond
claim "friction in the joints is named" diagnosed joint passive_joint_friction $joint
claim "both are named" diagnosed both cylinder_coulomb_friction,passive_joint_friction $coulomb $joint

accepted() {
    "$hexid" run -c "$work/coulomb/model.yaml" --print-config >"$work/printed" && grep -q 'force_extend_n: [45][0-9]' "$work/printed"
}
claim "the extended model is a configuration, with the effect in it" accepted
validated() { rig again --seed 6 $coulomb && gap coulomb --validate "$work/again.lcm" --json "$work/v.json" && says "$work/v.json" cylinder_coulomb_friction; }
claim "a second log judges instead of held-out cycles" validated
motion() { gap coulomb --replay motion --json "$work/m.json" >/dev/null && says "$work/m.json" cylinder_coulomb_friction; }
claim "the measured motion alone is enough" motion
other_frequency() { refuses 2 "move at 4 Hz" "$hexid" gap --measured "$work/none.lcm" -c config/tian2015.yaml -o "$work/f" --set tests.frequency_hz=5; }
claim "a log of another frequency is refused, and nothing is written" eval 'other_frequency && [ ! -e "$work/f" ]'
