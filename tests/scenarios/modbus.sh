#!/bin/bash
# The daemon and the plant as two processes on Modbus TCP and a serial line, with another maker's programs at either end.
. tests/scenarios/lib
on_own_machine "daemon and plant on Modbus" tests/uml/modbus_checks.sh
