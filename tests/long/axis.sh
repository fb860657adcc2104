#!/bin/bash
# All motions of one axis with every hidden effect; make test runs a third of them.
MORE_CASES=1 exec "${BUILD:-build}/tests/test_axis"
