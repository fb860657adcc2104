#!/bin/bash
# The daemon killed and the daemon stopped, as the system would do it, and what `--rt require` then demands.
. tests/scenarios/lib
on_own_machine "a daemon killed, and stopped" tests/uml/signals_checks.sh
