#!/bin/bash
# What a valve makes of noisy commands, beyond the hysteresis of make test: a small one, a rate limit, a delay.
MORE_CASES=1 exec tests/scenarios/gap_valve.sh
