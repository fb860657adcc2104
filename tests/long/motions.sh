#!/bin/bash
# A motion that takes minutes is evaluated part by part.
MORE_CASES=1 exec tests/scenarios/motions.sh
