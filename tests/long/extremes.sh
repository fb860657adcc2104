#!/bin/bash
# Every numeric key at its ends and between them, with all that doctor and a run look at: works, or is refused in words.
exec "${BUILD:-build}/tests/test_extremes" all
