/* The whole configuration as plain data, SI units, written once by src/io/config.c and constant
 * afterwards. Every key of the YAML file is one member here; ranges and descriptions stand in the
 * table of src/io/config_keys.c, which --print-config and docs/configuration.md print, too. */
#ifndef HEXID_PARAMS_H
#define HEXID_PARAMS_H

#include "effect.h"
#include "types.h"

enum { PARAMS_TEXT_SIZE = 256 };  /* of every text */

enum mechanism_kind { MECHANISM_STEWART, MECHANISM_AXIS };

/* Of each leg its own, as drawn. */
struct leg_vectors {
    bool given;
    double leg[LEGS][3];
};

struct geometry_params {          /* Tian 2015 Table 1 */
    double upper_radius_m;        /* Ra */
    double lower_radius_m;        /* Rb */
    double height_m;              /* H: the upper joint plane, z = 0 of the platform's drawing,
                                   * above the lower one, z = 0 of the base's, at neutral */
    double upper_half_angle_rad;  /* alpha */
    double lower_half_angle_rad;  /* beta */
    /* In the drawings of platform and base: x forward, y right, z down. */
    struct leg_vectors upper, lower; /* joints, m; not given: on a circle, by the numbers above */
    struct leg_vectors upper_axis, lower_axis; /* direction of the first axis of each universal
                                      * joint, fixed in platform or base, of any length; not given:
                                      * level, tangential to the joint circle */
};

struct payload_params {           /* Tian 2015 Table 2 */
    double mass_kg;
    /* about its mass centre: entries of the matrix */
    double inertia_xx_kg_m2, inertia_yy_kg_m2, inertia_zz_kg_m2;
    double inertia_xy_kg_m2, inertia_xz_kg_m2, inertia_yz_kg_m2;
    double center_height_m;       /* h: mass centre above the upper joint plane */
    double center_x_m, center_y_m;/* and in the platform's drawing */
    double gravity_mps2;
};

struct axis_params {              /* one cylinder or electric axis with a mass: leg 1,
                                   * the others are not there */
    double mass_kg;               /* all that moves */
    double gravity_mps2;          /* component along the axis; positive: the
                                   * weight pushes the rod in */
    double middle_m;              /* reading of the position at mid-stroke */
    double force_offset_n;        /* constant force that the reading has too much */
    double force_lag_s;           /* first order, of a force sensor's amplifier */
};

struct actuator_params {          /* the legs, Tian 2015 Tables 1 and 2; inertias about each part's
                                   * own mass centre (docs/method.md, 3) */
    double piston_diameter_m[LEGS], rod_diameter_m[LEGS];
    struct {
        bool piston, rod;
    } stated;                     /* false: of an axis whose configuration leaves the diameter out;
                                   * the built-in platform's is none of an axis's cylinder */
    double stroke_m[LEGS];
    double mid_stroke_m[LEGS];    /* length in the middle of the stroke less that at neutral */
    double upper_mass_kg[LEGS], lower_mass_kg[LEGS];             /* ma rod, mb cylinder */
    double upper_inertia_kg_m2[LEGS], lower_inertia_kg_m2[LEGS]; /* ia, ib: transverse */
    /* ra from the upper, rb from the lower joint */
    double upper_center_m[LEGS], lower_center_m[LEGS];
};

struct hydraulics_params {
    double supply_pa, tank_pa;
    double valve_flow_m3_per_s[LEGS]; /* per port at full opening and valve_drop_pa */
    double valve_drop_pa;
    double valve_frequency_hz, valve_damping[LEGS];
    double bulk_modulus_pa[LEGS];
    double dead_volume_m3[LEGS];      /* each side, */
    double dead_volume_difference_m3[LEGS]; /* and so much more on the rod side */
    double leakage_m3_per_s_pa[LEGS]; /* across the piston */
    double viscous_n_s_per_m[LEGS];   /* base model; effect cylinder_viscous_friction adds to it */
    double stop_stiffness_n_per_m, stop_damping_n_s_per_m; /* end stops of the stroke */
};

struct sensor_params {            /* of the simulated machine */
    bool enabled;                 /* false: exact values */
    double position_resolution_m;
    double adc_bits, adc_range_v; /* +- range */
    double pressure_full_scale_pa;/* at adc_range_v */
    double pressure_noise_v;      /* peak to peak, uniform */
};

enum engine_kind { ENGINE_ODE, ENGINE_CLOSED_FORM };

struct sim_params {
    enum engine_kind engine;
    int substeps;                 /* per cycle; a substep is at most 0.25 ms */
    double base_hz, base_mass_kg; /* the base on springs (sim/surroundings.h); 0 Hz: rigid */
    double ripple_pa, ripple_hz;  /* of the pump */
    double smooth_friction_mps;   /* 0: true stick; else the cylinders' dry friction is F
                                   * tanh(v / this), as where stick is not modelled */
};

struct control_params {           /* exact law: src/core/pid.h */
    double kp, ki, kd;            /* 1/m, 1/(m s), s/m */
    double kff;                   /* s/m, of the reference's leg rate */
    double kpf;                   /* 1/N, of the high-passed leg force */
    double tf, tp;                /* s, filters of derivative and force */
    double integral_limit;        /* of full opening */
    double output_limit;          /* of full opening */
};

struct motion_params {
    double engage_s, park_s;      /* of the moves, or longer where these limits ask for it: */
    double rate_mps, accel_mps2;  /* of the origin, or of the upper joints where it turns */
    double park_z_m;              /* pose z at which the platform is put down; z is down */
    double hold_s;                /* at neutral before the first test */
    bool automatic;               /* engage, test and park without commands */
};

struct limit_params {             /* SAFETY: beyond any of these the supervisor centres the
                                   * valves */
    double length_min_m[LEGS], length_max_m[LEGS];
    double leg_rate_mps;
    double following_m;           /* |leg reference - leg length| while engaged */
    double standstill_m;          /* range of a leg's reference since its length last
                                   * changed, while engaged */
    double force_n;               /* |A1 P1 - A2 P2| per leg */
    double sensor_age_s;
    double pressure_min_pa, pressure_max_pa; /* plausible sensor range */
    int bad_cycles;               /* leaky bucket: so many bad cycles more than good ones */
    double blind_time_s;          /* the most that blind_time() may come to */
    double oscillation_mps2;      /* the platform's acceleration beyond twice what is asked for:
                                   * src/core/oscillation.h */
};

struct interlock_params {         /* SAFETY: which of the machine's inputs and outputs are wired;
                                   * what is not is not watched */
    bool emergency_stop, enable, door, pressure;
    bool supply;                  /* the output that keeps the supply on */
    double pressure_s;            /* until `pressure` closes, at most; without that input: the
                                   * wait */
    bool antivalent;              /* each input comes twice, plain and inverse (interlock.h) */
    double discrepancy_s;         /* the two may agree so long before that is a fault */
};

struct test_params {
    enum dof order[DOFS];         /* axes to test, in turn */
    int count;
    double hz[DOFS];              /* frequency, of each axis its own */
    double amplitude[DOFS];       /* m; rad */
    double settle_s, ramp_s, duration_s, ramp_out_s; /* duration_s: the evaluated part */
    int harmonics;                /* regressed with the fundamental */
    bool multisine;               /* all axes of `order` at once, in one test */
    char trajectory[PARAMS_TEXT_SIZE]; /* file of poses over time, which takes the
                                        * sinusoids' place; "": none */
    int repeat;                   /* passes of it */
};

/* One axis after another, each a sinusoid: what methods A and B need. Else the run is one
 * test of no axis. */
static inline bool tests_single(const struct test_params *t) { return !t->multisine && !t->trajectory[0]; }
static inline int tests_count(const struct test_params *t) { return tests_single(t) ? t->count : 1; }
static inline const char *tests_name(const struct test_params *t, enum dof dof) {
    return dof != DOF_NONE ? dof_names[dof] : t->trajectory[0] ? "trajectory" : t->multisine ? "multisine" : "none";
}

struct check_params {             /* percent; beyond any of these the run's verdict is fail */
    double amplitude_pct;         /* achieved against commanded */
    double unwanted_pct;          /* motion of the other axes */
    double overruns_pct;          /* of the cycles */
    double excluded_pct;          /* of the evaluated samples */
    double length_wander_m;       /* of the fundamental of a leg's length, from
                                   * period to period of a test */
    double force_wander_n;        /* of a leg's mean force and its fundamental, from period to
                                   * period; of the mean also from test to test */
    double period_s;             /* a longer cycle puts the staircase of the
                                  * command into the matrix */
    double symmetry_pct;          /* |Mt - Mt'| against sqrt of the diagonal's product */
};

struct tolerance_params {         /* relative but for the joints: how far the model's parameters may
                                   * be off without that being a finding (hexid gap) */
    double mass;                  /* every mass and inertia */
    double viscous, bulk_modulus, leakage, valve_gain;
    double joints_m;              /* each coordinate of each joint */
    double springs_n_per_m, springs_nm_per_rad; /* hoses, cables: on x, y, z and on the angles */
};

struct model_params {
    struct tolerance_params tolerance;
};

struct loop_params {
    double period_s;
    int priority;                 /* SCHED_FIFO */
    int cpu;                      /* to pin to, -1: none */
    int overrun_limit;            /* so many deadlines missed in a row are a fault */
};

struct security_params {
    bool confine;                 /* the running daemon may ask little of the
                                   * system (src/rt/confine.h) */
};

struct machine_params {
    char name[PARAMS_TEXT_SIZE]; /* machine.h; "": the first that is free of hexid, hexid-2, ... */
};

struct lcm_params {
    char url[PARAMS_TEXT_SIZE];   /* "" none; udpm ttl 0 stays on the host */
    int state_every;              /* one HEXID_STATE on the wire for so many cycles */
    bool commands;                /* SAFETY: accept commands that move; stop and
                                   * park are always accepted */
    double lease_s;               /* SAFETY: who engaged or started by command must be heard so
                                   * often, or the platform is parked; 0: need not */
    char remote_stop[PARAMS_TEXT_SIZE]; /* addresses of other hosts whose stop and park are taken;
                                         * "": none */
};

/* One kind of channel between the field and hexid, leg by leg:
 * si = si_min + (raw - raw_min) / (raw_max - raw_min) (si_max - si_min) + offset. Readings outside
 * low..high (SI, offset included) are not plausible. A 4-20 mA or 0-10 V sensor behind a node is
 * just other numbers. */
struct channel_params {
    double raw_min[LEGS], raw_max[LEGS]; /* what the bus carries */
    double si_min[LEGS], si_max[LEGS];
    double offset[LEGS];
    double low[LEGS], high[LEGS];
};

struct device_params {            /* of the devices at the field end, set by the
                                   * daemon where the bus allows */
    double watchdog_s;            /* without a command for so long the device centres its valve */
};

struct can_params {
    double bitrate_bps;
    double heartbeat_s;           /* sent by every node and by the daemon; three
                                   * in a row missing: lost */
    /* What the nodes must say of themselves (0x1000, 0x1018:1, :2), rounded; -1: anything. */
    double device_type, vendor_id, product_code;          /* axis nodes */
    double io_device_type, io_vendor_id, io_product_code; /* node 7, inputs and outputs */
};

struct modbus_params {
    int unit;                     /* slave address */
};

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
    struct model_params model;
    struct loop_params loop;
    struct security_params security;
    struct machine_params machine;
    struct lcm_params lcm;
    struct channel_params length_channel, p1_channel, p2_channel, valve_channel;
    struct device_params device;
    struct can_params can;
    struct modbus_params modbus;
    struct effect_values effects[EFFECTS_MAX]; /* by place in effect_table */
};

static inline int params_legs(const struct params *p) { return p->mechanism == MECHANISM_AXIS ? 1 : LEGS; }

#endif
