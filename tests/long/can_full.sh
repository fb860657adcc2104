#!/bin/bash
# Through the kernel's CAN in real time: the six tests as shipped, 4 Hz and 5 s each, and the fault campaign: six minutes.
LIMIT_S=800 exec tests/uml/can bash tests/uml/can_full.sh
