#!/bin/bash
# Every gain from 0.1 to 1000 times the shipped one, on all three machines and both engines: just what shakes is refused.
exec "${BUILD:-build}/tests/test_loop_check" all
