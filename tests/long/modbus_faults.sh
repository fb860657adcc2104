#!/bin/bash
# The fault campaign on Modbus TCP.
. tests/scenarios/lib
LIMIT_S=850 on_own_machine "faults on Modbus" tests/uml/modbus_faults.sh
