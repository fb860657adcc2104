#!/bin/bash
# The inputs that fuzzing found worth keeping, run again.
. tests/scenarios/lib
for corpus in tests/fuzz/corpus/*/; do
    name=$(basename "$corpus")
    claim "kept inputs of fuzz_$name: none breaks anything" "${BUILD:-build}/tests/fuzz/replay_$name" "$corpus"*
done
