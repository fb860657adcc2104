#!/bin/bash
# Every signal that ends or stops a process, and every signal of a crash; make test has one of each kind.
MORE_CASES=1 exec tests/scenarios/stop.sh
