#!/bin/bash
# Gains from 0.1 to 1000 times the shipped ones, eight per decade, from the stops and from neutral, on all machines: none shakes for long.
OSCILLATION_GRID=full exec "${BUILD:-build}/tests/test_oscillation"
