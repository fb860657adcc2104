#!/bin/bash
# The README's commands, typed by somebody who has an installed hexid and no checkout.
MORE_CASES=1 exec tests/scenarios/install.sh
