#!/bin/bash
# Faults of any kind, size and time, four times as many as in make test.
MORE_CASES=1 exec tests/scenarios/faults.sh
