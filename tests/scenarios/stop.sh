#!/bin/bash
# A stop works whatever else is broken or flooded: terminals, logs, signals, the network, a second master, a crash.
# With MORE_CASES, in `make test-long`: every signal, and a flood of packets.
. tests/scenarios/lib
on_own_machine "a stop works whatever else is broken" --can tests/uml/stop_checks.sh
