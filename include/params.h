/* The whole configuration as plain data in SI units; src/io/config.c reads it from the YAML file,
 * and while the daemon runs it is constant. Every key of the file but `mechanism` sets one member
 * of a section; a module that reads one section includes its header alone. Ranges and descriptions
 * of the keys stand in the table of src/io/config_keys.c, from which --print-config and
 * docs/configuration.md are made. */
#ifndef HEXID_PARAMS_H
#define HEXID_PARAMS_H

#include "effect.h"
#include "mechanism.h"
#include "params/actuator.h"
#include "params/axis.h"
#include "params/checks.h"
#include "params/control.h"
#include "params/daemon.h"
#include "params/field.h"
#include "params/found.h"
#include "params/geometry.h"
#include "params/hydraulics.h"
#include "params/interlocks.h"
#include "params/limits.h"
#include "params/loop.h"
#include "params/model.h"
#include "params/motion.h"
#include "params/payload.h"
#include "params/qualify.h"
#include "params/sensor_errors.h"
#include "params/sensors.h"
#include "params/sim.h"
#include "params/tests.h"
#include "types.h"

struct params {
    enum mechanism_kind mechanism;
    struct geometry_params geometry;
    struct payload_params payload;
    struct axis_params axis;
    struct actuator_params actuator;
    struct hydraulics_params hydraulics;
    struct sensor_params sensors;
    struct sim_params sim;
    struct control_params control;
    struct motion_params motion;
    struct limit_params limits;
    struct interlock_params interlocks;
    struct test_params tests;
    struct check_params checks;
    struct qualify_params qualify;
    struct model_params model;
    struct found_params found;
    struct loop_params loop;
    struct security_params security;
    struct machine_params machine;
    struct lcm_params lcm;
    struct channel_params length_channel, p1_channel, p2_channel, valve_channel;
    struct device_params device;
    struct can_params can;
    struct modbus_params modbus;
    struct sensor_errors errors;
    struct effect_values effects[EFFECTS_MAX]; /* values of all effects, in the order of
                                                * effect_table */
};

#endif
