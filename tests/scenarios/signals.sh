#!/bin/bash
# The daemon killed and stopped, as the system would do it, and the resulting requirements of `--rt require`.
. tests/scenarios/lib
on_own_machine "a daemon killed, and stopped" tests/uml/signals_checks.sh
