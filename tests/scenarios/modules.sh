#!/bin/bash
# Every module has a test that `make check T=MODULE` finds, and neither tests/modules nor the table of
# mutations has a line that is out of date.
. tests/scenarios/lib

claim "every module has a test of its name or a line in tests/modules" "$python" tests/scenarios/modules.py complete
claim "no line of tests/modules is out of date" "$python" tests/scenarios/modules.py current
claim "every C test has the modules linked that it is said to hold" "$python" tests/scenarios/modules.py linked "${BUILD:-build}"
claim "tests/mutation/table.py finds each line of the code that it breaks" "$python" tests/mutation/mutate.py --stale
