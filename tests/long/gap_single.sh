#!/bin/bash
# One effect is hidden.
. tests/long/score_lib

claim "leakage in some leg is named, though joints and supply are off" right internal_leakage typical 1 beyond
claim "friction in the joints is named" right passive_joint_friction typical 3 tolerance
claim "a heavier payload is named" right payload_mass typical 2 tolerance
claim "a slow pressure sensor is named" right pressure_sensor_lag typical 1 tolerance
claim "joints that lie elsewhere are named" right geometry_error strong 100 tolerance
claim "joints that lie elsewhere in every leg are no tilt" right geometry_error typical 302 tolerance
claim "valves that stay shut leave chambers without a steady state, and are named" right valve_dead_band strong 300 tolerance
