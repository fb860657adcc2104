#!/bin/bash
# Time for which the machine moves without a living controller: computed, and observed at the device.
. tests/scenarios/lib
LIMIT_S=850 on_own_machine "a daemon killed and stopped at random moments" --can tests/uml/blind_time.sh
