#!/bin/bash
# Every numeric key at its ends and between them, with everything that doctor and a run check: it works, or is refused in words.
exec "${BUILD:-build}/tests/test_extremes" all
