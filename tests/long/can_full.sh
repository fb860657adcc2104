#!/bin/bash
# The six tests of the configuration as shipped, 4 Hz and 5 s each, through the kernel's CAN in real time: 75 seconds.
exec tests/uml/can bash tests/uml/can_full.sh
