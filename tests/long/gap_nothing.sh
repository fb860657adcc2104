#!/bin/bash
# No effect of the catalogue is hidden.
. tests/long/score_lib

claim "nothing but the base's tolerance: no gap" right none typical 1 tolerance
claim "a base on springs is no effect of the catalogue, and said to be none" right unknown_base_spring typical 11 tolerance
claim "nothing but what no tolerance states: no gap" right none typical 2 beyond
claim "a leg that may be held takes up noise: that is no friction" right none typical 706 tolerance
