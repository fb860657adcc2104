#!/bin/bash
# More hidden cases than make test has time for.
MORE_CASES=1 exec tests/scenarios/gap_score.sh
