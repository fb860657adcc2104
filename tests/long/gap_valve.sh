#!/bin/bash
# A valve's response to noisy commands, in more cases than in make test: a small hysteresis, a rate limit, a delay.
MORE_CASES=1 exec tests/scenarios/gap_valve.sh
