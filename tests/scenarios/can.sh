#!/bin/bash
# The daemon and the plant as two processes on a kernel's CAN bus, with other makers' programs at either end.
# With MORE_CASES, in `make test-long`: readings doubled on the wire.
. tests/scenarios/lib
on_own_machine "daemon and plant on CAN" --can tests/uml/can_checks.sh
