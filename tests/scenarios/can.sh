#!/bin/bash
# The daemon and the plant as two processes on a kernel's CAN bus, and other makers' programs at either end.
# Runs alone.
. tests/scenarios/lib
skip_under 'asan|tsan' CAN "sanitizers do not start in a user-mode kernel; tests/test_can.c runs the same nodes and master in memory"
LIMIT_S=600 tests/uml/can bash tests/uml/can_checks.sh
