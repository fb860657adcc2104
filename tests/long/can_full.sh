#!/bin/bash
# Through a kernel's CAN: the six tests as shipped, 4 Hz and 5 s each, and the fault campaign.
. tests/scenarios/lib
LIMIT_S=850 on_own_machine "whole runs and faults on CAN" --can tests/uml/can_full.sh
