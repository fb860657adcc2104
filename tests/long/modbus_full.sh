#!/bin/bash
# Over Modbus TCP and a serial line: the six tests as shipped, 4 Hz and 5 s each.
. tests/scenarios/lib
LIMIT_S=850 on_own_machine "whole runs on Modbus" tests/uml/modbus_full.sh
