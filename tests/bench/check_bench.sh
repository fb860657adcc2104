#!/bin/bash
# Checks `make bench`.
. tests/bench/check_lib
export RUNS=2 SHARE=25 SECONDS_OF=1 TURNS=0
operations=$("$BUILD/tests/bench/bench") || operations=none
whole() { cp -r "$BUILD/tests/bench/bench" "$work/b/tests/bench/" && ln -s "$hexid" "$work/b/hexid"; tests/bench/bench.sh "$work/b"; }
mkdir -p "$work/b/tests/bench"
claim "make bench measures every operation, in time and in instructions" table 4 "$operations" whole
claim "its other rows are there, too" tests/bench/measured.py "$work/table" 3 \
    $(sed -n 's/^sim_step/sim_real_time_factor/p' <<<"$operations") $(sed -n 's/^sim_step_ode/sim_over_dWorldStep_ode/p' <<<"$operations") \
    identify_6_x_1_s
claim "and so are they in its CSV" tests/bench/measured.py "$work/b/bench.csv" 5 $operations
rm "$work/b/hexid" && cp "$work/empty/hexid" "$work/b/hexid"
claim "a hexid that does nothing is no row" fails env RUNS=1 SHARE=250 tests/bench/bench.sh "$work/b"
printf '#!/bin/sh\n[ -n "$1" ] || echo fk_tracking\n' >"$work/b/tests/bench/bench"
claim "a benchmark that prints nothing is no row" fails tests/bench/bench.sh "$work/b"
claim "the table of before is not left in its place" fails test -e "$work/b/bench.csv"
