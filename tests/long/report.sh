#!/bin/bash
# The report on a motion that takes minutes.
MORE_CASES=1 exec tests/scenarios/report.sh
