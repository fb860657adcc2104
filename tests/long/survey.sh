#!/bin/bash
# A survey of a machine whose pieces are short, with another seed than in make test.
MORE_CASES=1 exec tests/scenarios/survey.sh
