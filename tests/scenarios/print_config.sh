#!/bin/bash
# The effective configuration is a configuration.
. tests/scenarios/lib

settings=(--set tests.frequency_hz=3.3 --set effects.cylinder_coulomb_friction.force_extend_n='[1,2,3,4,5,6.5]' --tests z,psi)
"$hexid" run --print-config "${settings[@]}" >"$work/effective.yaml"
"$hexid" run --print-config -c "$work/effective.yaml" >"$work/again.yaml"
claim "what --print-config prints is accepted by -c and printed again alike" cmp "$work/effective.yaml" "$work/again.yaml"
claim "it has what --set changed" grep -q "frequency_hz: 3.3" "$work/effective.yaml"
"$hexid" run --print-config -c config/tian2015.yaml >"$work/file.yaml"
(cd "$work" && "$hexid" run --print-config) >"$work/built_in.yaml"
claim "config/tian2015.yaml is the built-in default" cmp "$work/file.yaml" "$work/built_in.yaml"
