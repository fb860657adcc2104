#!/bin/bash
# Every gain from 0.1 to 1000 times the shipped one, on all three machines and both engines: exactly the gains that shake are refused.
exec "${BUILD:-build}/tests/test_loop_check" all
