#!/bin/bash
# Searches for effects on a log of config/simulator.yaml; make test searches only on the desk-top platform's log.
MORE_CASES=1 exec tests/scenarios/machines.sh
