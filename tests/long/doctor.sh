#!/bin/bash
# A machine with a singular pose near neutral. hexid run warns of it, as hexid doctor does.
MORE_CASES=1 exec tests/scenarios/doctor.sh
