#!/bin/bash
# Runs the inputs that fuzzing has collected.
. tests/scenarios/lib
for corpus in tests/fuzz/corpus/*/; do
    name=$(basename "$corpus")
    claim "kept inputs of fuzz_$name: none breaks anything" "${BUILD:-build}/tests/fuzz/replay_$name" "$corpus"*
done
