#!/bin/bash
# Surveys with two seeds of a machine whose segments are short, and a survey that judges tests which do not suit the machine.
MORE_CASES=1 exec tests/scenarios/survey.sh
