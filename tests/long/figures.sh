#!/bin/bash
# Compares the engine ODE at half the step with an independent simulation.
MORE_CASES=1 exec tests/scenarios/figures.sh
