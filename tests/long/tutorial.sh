#!/bin/bash
# The tutorial's commands work, and print what it shows.
MORE_CASES=1 exec tests/scenarios/pages.sh
