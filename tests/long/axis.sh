#!/bin/bash
# All motions of one axis with all that may be hidden in them: make test has half of them.
MORE_CASES=1 exec "${BUILD:-build}/tests/test_axis"
