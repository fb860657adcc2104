#!/bin/bash
# The daemon and the plant as two processes on a kernel's CAN bus, and other makers' programs at either end.
# Runs alone.
if ldd "${BUILD:-build}/hexid" | grep -q 'lib[at]san'; then
    echo "ok - CAN # SKIP sanitizers do not start in a user-mode kernel; tests/test_can.c runs the same nodes and master in memory"
    exit
fi
LIMIT_S=600 exec tests/uml/can bash tests/uml/can_checks.sh
